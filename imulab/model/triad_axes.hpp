// The axes of the gyros against those of the accelerometers.
#pragma once

#include "imulab/core/rotation.hpp"

#include <string>

namespace imulab {

/// Axes that are swapped, reversed or left-handed, in words; empty where the gyros turn as gravity does. `gyro`: the matrix from the gyros' readings
/// to the rate at which gravity turns in the accelerometers' axes.
std::string wrong_axes(const Matrix3d& gyro);

}  // namespace imulab
