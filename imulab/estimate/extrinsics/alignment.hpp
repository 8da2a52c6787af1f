// Start of the extrinsics: clock offsets by angular rates, which need no axes, and rotations by rates and forces.
#pragma once

#include "imulab/estimate/extrinsics/stream.hpp"

#include <optional>
#include <string>

namespace imulab::extrinsics {

struct Alignment {
  double offset = 0;                      ///< s: clock of the other IMU minus that of the first
  double agreement = 0;                   ///< correlation of the angular rates there
  std::optional<double> second_offset{};  ///< another one that fits as well
  Matrix3d rotation = Matrix3d::Identity();
};

/// Aligns `other` with `first`. Throws Error for the same readings twice, and Unsupported where no 5 s are in common, nothing turns, or an axis of
/// one has another sign than its others.
Alignment aligned(const Stream& first, const Stream& other, const std::string& first_name, const std::string& other_name);

}  // namespace imulab::extrinsics
