// What a number in a session file may be.
#pragma once

#include <limits>

namespace imulab {

enum class Presence { required, optional };

/// A number's unit and range. The factor brings it to SI; the range is in the file's unit.
struct Number {
  double factor = 1;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool above_low = false;  ///< low itself is out of range
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

}  // namespace imulab
