// Axes of a calibration: what the accelerometers' frame fixes, and gyros that do not turn as gravity does.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <string>

namespace imulab {

/// An element of accel.matrix above the diagonal: zero by the choice of this frame.
bool zero_by_frame(CoefficientIndex index);

// The axes of the gyros against those of the accelerometers.

/// Axes that are swapped, reversed or left-handed, in words; empty where the gyros turn as gravity does. `gyro`: the matrix from the gyros' readings
/// to the rate at which gravity turns in the accelerometers' axes.
std::string wrong_axes(const Matrix3d& gyro);

}  // namespace imulab
