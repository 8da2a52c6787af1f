#include "imulab/core/fields.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::fields {

bool in_range(double value, const Number& kind) { return value >= kind.low && value <= kind.high && !(kind.above_low && value == kind.low); }

std::string out_of_range(double value, const Number& kind) {
  if (std::isinf(kind.high)) return fmt::format("{} is out of range; expected {} {}", value, kind.above_low ? "more than" : "at least", kind.low);
  if (kind.above_low) return fmt::format("{} is out of range; expected more than {}, at most {}", value, kind.low, kind.high);
  return fmt::format("{} is out of range; expected {} to {}", value, kind.low, kind.high);
}

}  // namespace imulab::fields
