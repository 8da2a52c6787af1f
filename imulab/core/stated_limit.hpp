// A limit on a figure as people state it: "gyro.N <= 0.1 deg/sqrt(h)", "CEP <= 200 m at 600 s".
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

struct StatedLimit {
  std::string name;            ///< "CEP"
  double number = 0;           ///< above 0
  std::string unit;            ///< "m"; empty where none was given
  std::optional<double> at_s;  ///< from the begin on; absent: at the end
};

/// Returns true if the comma at `at` is in a number, as in "0,5".
bool is_decimal_comma(std::string_view text, std::size_t at);

/// "CEP <= 200 m at 600 s"
std::string to_string(const StatedLimit& limit);

/// Limits separated by commas. `form` and `example` are for the message: "FIGURE <= NUMBER UNIT", "CEP <= 1 nmi/h". Throws Error for text of another
/// form, and a number that is not above 0.
std::vector<StatedLimit> parse_limits(std::string_view text, std::string_view form, std::string_view example);

/// A unit in which a figure may be stated, and its size in SI.
struct StatedUnit {
  std::string name;
  double size;
};
/// A figure on which there may be limits. One name may stand for several with other units: "CEP" in m and in nmi/h.
struct StatedFigure {
  std::string name;
  std::vector<StatedUnit> units;
};
struct FoundFigure {
  std::size_t index;  ///< among the figures
  double limit;       ///< SI
};

/// The figure that a limit is on, by its name (capitals and blanks do not count) and its unit, or another of the same dimension. Throws Error that
/// names the nearest, and all that are possible.
FoundFigure find_figure(const StatedLimit& limit, const std::vector<StatedFigure>& figures);

}  // namespace imulab
