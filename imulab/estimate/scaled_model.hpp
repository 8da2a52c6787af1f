// The sensor model in readings that are centred and scaled, so that the normal equations are well conditioned whatever the raw unit.
#pragma once

#include "imulab/estimate/rest.hpp"
#include "imulab/model/coefficient.hpp"

#include <vector>

namespace imulab {

/// Readings far from zero (counts) are centred on the rests and scaled by gravity and by the motion; SI readings stay as they are.
Scaling choose_scaling(const Recording& recording, const std::vector<Rest>& rests);

/// The linear model of scaled readings, in raw readings: a = A0 + A1 (U - center) / scale.
SensorModel to_raw(const SensorModel& scaled, const Scaling& scaling);
SensorModel to_scaled(const SensorModel& raw, const Scaling& scaling);

/// Covariance of the table coefficients `indices`, from scaled to raw.
Eigen::MatrixXd covariance_to_raw(const Eigen::MatrixXd& covariance, const std::vector<int>& indices, const Scaling& scaling);

/// How far a scaled coefficient may be from its start: offsets g and 1 rad/s, scales 100 %, misalignments 1e-2 (methods: what an uncalibrated unit
/// has at most), g-sensitivity 1e-3 (rad/s)/(m/s^2), that is 5.6 deg/s/g. Decides only what counts as determined.
double coefficient_prior_sigma(const Coefficient& coefficient, const SensorModel& scaled_model, double gravity);

}  // namespace imulab
