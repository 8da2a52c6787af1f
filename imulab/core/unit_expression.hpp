// Units as data sheets print them: "mdps/√Hz", "°/s/rtHz", "deg/sqrt(h)", "(m/s^2)^2/Hz", "µg".
#pragma once

#include <optional>
#include <string_view>

namespace imulab {

/// A unit's size in SI and its dimension. An angle counts as a dimension of its own, so that rad/s is not Hz.
struct UnitExpression {
  double size = 1;
  double angle = 0, length = 0, time = 0;  ///< exponents of rad, m and s

  bool has_dimension_of(const UnitExpression& other) const { return angle == other.angle && length == other.length && time == other.time; }
  UnitExpression times(const UnitExpression& other, double power) const;
};

/// Returns the unit of a product, quotient, power or root of known units; capitals and blanks do not count. Absent: the text is no such unit.
std::optional<UnitExpression> parse_unit_expression(std::string_view text);

/// Returns true if both texts are the same unit, as "dps" and "deg/s".
bool is_same_unit(std::string_view one, std::string_view other);
/// Returns the size of the unit `text` if it has the dimension of the unit `name`, whose size is `size`: another spelling or a multiple.
std::optional<double> size_of_unit_like(std::string_view text, std::string_view name, double size);

}  // namespace imulab
