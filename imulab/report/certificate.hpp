// The calibration certificate of a laboratory, for paper: two A4 pages with what ISO/IEC 17025:2017, 7.8.1 to 7.8.4 and 7.8.6, lists, then an
// appendix. It states what was measured and declared. What nobody has declared is a line to fill in, "not traceable" or "not an accredited
// certificate"; nothing here says that a laboratory or a calibration conforms to that standard.
#pragma once

#include "imulab/formats/laboratory/file.hpp"
#include "imulab/report/calibration_page.hpp"

#include <string>

namespace imulab {

struct Certificate {
  CalibrationReport report;
  Laboratory laboratory = {};
  std::string number = {};             ///< empty: a line to fill in
  std::string file = {}, sha256 = {};  ///< of the calibration
};

/// HTML, self-contained, without scripts. Throws Unsupported for a calibration without uncertainties: a certificate states results with theirs.
std::string certificate_page(const Certificate& certificate);

}  // namespace imulab
