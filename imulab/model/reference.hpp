// What a calibration's scales come from, as far as somebody declares it: no data show it.
#pragma once

#include <string>

namespace imulab {

/// The instrument behind a quantity, and its certificate. None of this is checked.
struct Reference {
  std::string quantity;    ///< acceleration, rotation, time or temperature
  std::string instrument;  ///< make, type, serial number
  std::string certificate;
  std::string date;       ///< of the certificate, YYYY-MM-DD; may be empty
  std::string statement;  ///< of the certificate: "U = 2 arcsec, k = 2"; may be empty
  bool operator==(const Reference&) const = default;
};

}  // namespace imulab
