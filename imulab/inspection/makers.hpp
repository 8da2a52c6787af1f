// Names of clocks whose unit their maker documents, and which is none of s, ms, us and ns, or which the name does not say.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace imulab::inspection {

struct MakersClock {
  std::string_view name;     ///< of the column: small letters and digits alone
  std::string_view maker;    ///< whose clock it is, for people
  double ticks_per_s;        ///< 1, 1e3, 1e6, 1e9 are s, ms, us, ns
  double least_hz, most_hz;  ///< rates that such a device puts out: two makers may use one name
};

/// The clock of that name which at `step` numbers a row has a rate that its device puts out; nothing where none has, or several.
std::optional<MakersClock> makers_clock(std::string_view name, double step);

}  // namespace imulab::inspection
