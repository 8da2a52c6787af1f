// The accelerometers' frame: a body frame into which every calibration can be converted.
//
// x_b lies along the x accelerometer's sensitive axis and y_b in the plane of the x and y accelerometers' sensitive axes, so accel.matrix is
// lower triangular with a positive diagonal. (For a left-handed triad, det A1 < 0, no rotation can do that: there its last element is negative.)
//
// Example:
//   const Calibration comparable = in_accelerometer_frame(calibration);  // with its covariance
//
// Throws Error where the accelerometers' matrix is singular. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

namespace imulab {

/// R, the rotation from the frame of `accel_matrix` (A1) to the accelerometers' frame: R A1 is lower triangular. Throws Error for a singular A1.
Matrix3d accelerometer_frame(const Matrix3d& accel_matrix);

/// The calibration in the accelerometers' frame, a' = R a and w' = R w: offsets and matrices R x, lever arms R r_i, g-sensitivity R C R^T; the
/// thermal terms belong to the raw outputs and stay. The quadratic and cubic terms stay as they are too: rotated, they would no longer be diagonal.
/// The covariance follows, R's own dependence on A1 included; the three elements of accel.matrix above the diagonal are zero by definition and
/// are no longer among the estimated.
Calibration in_accelerometer_frame(const Calibration& calibration);

}  // namespace imulab
