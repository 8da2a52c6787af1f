// Linear coarse solutions without a rig: the start of the maximum-likelihood refinements (Cheng 2014 sec 1.2, "shape from motion").
#pragma once

#include "imulab/recording/scaling.hpp"

#include <optional>

namespace imulab::coarse {

/// Accelerometers from |f| = g at every rest: (U - B)^T Q (U - B) = g^2 is linear in nine unknowns (Cheng 2014 eqs 6-10). `matrix` is lower
/// triangular (x_b along the x accelerometer, y_b in the plane of the x and y accelerometers).
struct CoarseAccel {
  Vector3d offset;
  Matrix3d matrix;
  bool misalignment;  ///< false: the rests do not determine the quadric's cross terms (cardinal positions), which are set to zero
};

/// Solves for the accelerometers; `readings` are scaled means of the rests. Empty if not even offsets and scales are determined.
std::optional<CoarseAccel> coarse_accel(const std::vector<Vector3d>& readings, double gravity);

/// Gyro offset and matrix from f . w = g w_ie sin L at every rest, linear in twelve unknowns (Cheng 2014 eqs 11-14).
struct CoarseGyro {
  Vector3d offset;
  Matrix3d matrix;
};
std::optional<CoarseGyro> coarse_gyro_at_rest(const std::vector<RestMeans>& rests, const SensorModel& scaled_model, const Scaling& scaling,
                                              double earth_rate_vertical);

/// Returns the gyro matrix from the motion between the rests: the measured direction of gravity changes by -w x f. Linear in nine unknowns and
/// accurate to some percent for any acceleration of the hand. Empty if the motion does not turn the unit about all axes.
std::optional<Matrix3d> coarse_gyro_in_motion(const Recording& recording, const std::vector<RestMeans>& rests, const SensorModel& scaled_model,
                                              const Scaling& scaling);

}  // namespace imulab::coarse
