// Two records of the motion of one rigid body: the offset of their clocks by angular rates, which need no axes, and the rotation between their axes.
#pragma once

#include "imulab/eigen.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::common_motion {

/// Means over an interval, body axes.
struct Sample {
  double begin = 0, end = 0;  ///< s
  Vector3d rate, force;       ///< rad/s, m/s^2; a stream without forces has zeros
};

struct Stream {
  std::vector<Sample> samples;
  double interval = 0;  ///< s, median
};

struct Alignment {
  double offset = 0;                         ///< s: clock of the other minus that of the first
  double agreement = 0;                      ///< correlation of the angular rates there
  std::optional<double> second_offset{};     ///< another one that fits as well
  Matrix3d rotation = Matrix3d::Identity();  ///< from the first's axes to the other's
  /// Second largest motion over the largest, common to both: 0 about one axis alone, and of forces along one direction alone.
  double second_rate = 0, second_force = 0;
};

/// What messages call the two, and what is expected of them: "two IMUs".
struct Names {
  std::string first, other, expected;
};

/// Aligns `other` with `first`. Throws Error for the same readings twice, and Unsupported where no 5 s are in common, nothing turns, an axis of one
/// has another sign than its others, or neither turns nor forces determine the rotation.
Alignment aligned(const Stream& first, const Stream& other, const Names& names);

}  // namespace imulab::common_motion
