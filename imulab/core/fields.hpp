// Declaration of a table's field: its presence, and a number's unit and range.
#pragma once

#include <limits>
#include <string>

namespace imulab::fields {

enum class Presence { required, optional };

/// A number's unit and range: multiplied by the factor it is in SI; the range is in the file's unit.
struct Number {
  double factor = 1;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool above_low = false;  ///< low itself is excluded
  Presence presence = Presence::required;
};

inline Number any_number(double factor = 1) { return {factor}; }
inline Number positive(double factor = 1) { return {factor, 0, std::numeric_limits<double>::infinity(), true}; }
inline Number not_negative(double factor = 1) { return {factor, 0}; }
inline Number within(double low, double high, double factor = 1) { return {factor, low, high}; }
inline Number or_default(Number number) {
  number.presence = Presence::optional;
  return number;
}

/// True for a number in the file's unit that is in its range.
bool in_range(double value, const Number& kind);
/// "100 is out of range; expected -90 to 90"
std::string out_of_range(double value, const Number& kind);

}  // namespace imulab::fields
