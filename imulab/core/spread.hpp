// A declared size of what a simulation draws.
#pragma once

namespace imulab {

/// A number that a simulation draws from: one sigma of a draw, or exactly itself.
struct Spread {
  double value = 0;
  bool fixed = false;
  bool operator==(const Spread&) const = default;
};

}  // namespace imulab
