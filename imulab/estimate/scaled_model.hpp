// The sensor model in readings that are centred and scaled, so that the normal equations are well conditioned whatever the raw unit.
#pragma once

#include "imulab/estimate/adjustment.hpp"
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

/// What is known of the coefficients before the data: a value and a standard deviation each, of scaled readings.
struct Prior {
  SensorModel mean;
  /// Offsets 20 % of g and 1 rad/s; scales 20 %; misalignments 1e-2 of their row (20 % where the row does not point along its axis: axes swapped);
  /// g-sensitivity 1e-3 (rad/s)/(m/s^2), 5.6 deg/s/g: uncalibrated units are within these.
  double sigma(const Coefficient& coefficient, double gravity) const;
  Eigen::VectorXd sigmas(const std::vector<int>& indices, double gravity) const;
};

/// Adds the prior's conditions as rows `row`, `row` + 1, ... of the coefficients, which are the first parameters.
void add_prior_rows(Conditions& conditions, Eigen::Index row, const Prior& prior, const Eigen::VectorXd& sigma, const SensorModel& model,
                    const std::vector<int>& indices);

}  // namespace imulab
