// The accelerometers' frame, a body frame to which every calibration can be converted.
//
// x_b is along the sensitive axis of the x accelerometer, and y_b is in the plane of the x and y sensitive axes. accel.matrix is therefore lower
// triangular with a positive diagonal. (In a left-handed triad, det A1 < 0, no rotation can achieve this: the last element is negative.)
//
// Example:
//   const Calibration comparable = in_accelerometer_frame(calibration);  // with its covariance
//
// Throws Error if the accelerometer matrix is singular. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

namespace imulab {

/// Returns the rotation R from the frame of `accel_matrix` (A1, any unit) to the accelerometers' frame, so that R A1 is lower triangular. Throws
/// Error if A1 is singular.
Matrix3d accelerometer_frame(const Matrix3d& accel_matrix);

/// Returns the calibration in the accelerometers' frame, a' = R a and w' = R w: offsets and matrices become R x, lever arms R r_i, the g-sensitivity
/// R C R^T. Thermal terms belong to the raw outputs and do not change. Quadratic and cubic terms are not rotated either, because they would no longer
/// be diagonal. The covariance includes the dependence of R on A1. The elements of accel.matrix above the diagonal are zero by definition and are
/// removed from `estimated`.
Calibration in_accelerometer_frame(const Calibration& calibration);

}  // namespace imulab
