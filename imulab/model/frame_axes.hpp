// Axes of a calibration: elements that the accelerometers' frame fixes, and gyros that do not turn with gravity.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <string>

namespace imulab {

/// Returns true for an element of accel.matrix above the diagonal, which is zero in this frame by definition.
bool zero_by_frame(CoefficientIndex index);

// The axes of the gyros relative to those of the accelerometers.

/// Describes axes that are swapped, reversed or left-handed; empty if the gyros agree with the rotation of gravity. `gyro`: matrix from the gyros'
/// readings to the rate of gravity's rotation in the accelerometers' axes.
std::string wrong_axes(const Matrix3d& gyro);

}  // namespace imulab
