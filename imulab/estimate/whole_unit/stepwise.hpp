// The starts of whole-unit calibration: the center of the readings, a linear model, and a check of the mounts; and Dai's three steps in sequence (Dai
// 2011 section 3.1), each by unweighted least squares, with the covariance of the whole chain due to noise and machine errors.
#pragma once

#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/rig/machine_points.hpp"
#include "imulab/sensor_model.hpp"

namespace imulab::whole_unit {

/// Returns the middle of the range for offset-binary counts, so that their powers remain distinguishable; zero for other readings.
Vector6d reading_center(const MachinePoints& points);

/// Returns the start for readings minus `center`: the identity for readings in SI, linear least squares over all points for counts. Throws
/// Unsupported if that does not determine a scale of counts.
SensorModel starting_model(const MachinePoints& points, const Session& session, const Vector6d& center);

/// Throws Error if the readings contradict a mount, and another mount or the opposite rate explains them.
void check_mounts(const MachinePoints& points, const Session& session, const SensorModel& start, const Vector6d& center);

struct StepwiseEstimate {
  SensorModel model;           ///< model of readings minus the problem's center
  Eigen::MatrixXd covariance;  ///< covariance of the problem's coefficients; zero if it was not requested
};

/// Estimates in three steps. Requires a chamber, a rate table with opposed mounts along every axis, and a centrifuge with each accelerometer axis
/// outward: otherwise throws Unsupported, also for points that do not determine their coefficients.
StepwiseEstimate stepwise_estimate(const PointProblem& problem, bool with_covariance);

}  // namespace imulab::whole_unit
