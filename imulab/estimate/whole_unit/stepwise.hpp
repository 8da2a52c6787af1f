// The starts of whole-unit calibration: the readings' center, a linear model, whether the IMU was mounted as the session says; and Dai's three steps
// one after the other (Dai 2011 section 3.1), each by unweighted least squares, with the covariance that noise and the machines' errors give the
// whole chain.
#pragma once

#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/rig/machine_points.hpp"
#include "imulab/sensor_model.hpp"

namespace imulab::whole_unit {

/// Offset-binary counts are centered on the middle of their range, so that powers of them remain distinguishable; other readings stay as they are.
Vector6d reading_center(const MachinePoints& points);

/// The start for readings less `center`. Readings in SI start from the identity, counts from linear least squares over all points. Throws
/// Unsupported where that does not determine a scale of counts.
SensorModel starting_model(const MachinePoints& points, const Session& session, const Vector6d& center);

/// Throws Error where the readings of a mount contradict it and another mount, or the opposite rate, explains them.
void check_mounts(const MachinePoints& points, const Session& session, const SensorModel& start, const Vector6d& center);

struct StepwiseEstimate {
  SensorModel model;           ///< of readings less the problem's center
  Eigen::MatrixXd covariance;  ///< of the problem's coefficients; zero where it was not asked for
};

/// Needs a chamber, a rate table with opposed mounts along every axis, and a centrifuge with an accelerometer of each axis outward: throws
/// Unsupported that says so, or which points do not determine their coefficients.
StepwiseEstimate stepwise_estimate(const PointProblem& problem, bool with_covariance);

}  // namespace imulab::whole_unit
