// Estimates of effects, including effects that a fit lacks, and the probability of its residuals.
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/rig/table_readings.hpp"

#include <cmath>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd Estimator::effects(const VectorXd& readings) const {
  return error_gain_.bottomRows(source_sigma_.size() - table()) * (readings - expected_);
}

/// S - S E^T B E S, where B is the inverse covariance of the readings minus the part absorbed by the coefficients.
MatrixXd Estimator::effects_covariance() const {
  const VectorXd variance = effects_sigma().cwiseAbs2();
  MatrixXd out = -error_gain_.bottomRows(variance.size()) * readings_by_effects() * variance.asDiagonal();
  out.diagonal() += variance;
  return 0.5 * (out + out.transpose());
}

double Estimator::log_likelihood(const VectorXd& readings) const {
  double log_determinant = free_covariance_.size() == 0 ? 0 : -2 * Cholesky(free_covariance_).lower().diagonal().array().log().sum();
  for (Index row = 0; row < weight_.size(); ++row)
    if (weight_[row] > 0) log_determinant += 2 * std::log(factor_.lower()(row, row) / weight_[row]);
  return -0.5 * (chi2(readings) + log_determinant);
}

std::vector<Estimator::Score> Estimator::scores(const VectorXd& readings, const std::vector<MatrixXd>& truth_changes) const {
  const Unexplained u = unexplained(readings);
  SensorModel model = backward(solve(readings));
  model.g_sensitivity.setZero();
  std::vector<Score> out;
  for (const MatrixXd& change : truth_changes) {
    const MatrixXd columns = weight_.asDiagonal() * reading_changes(motion_, model, change);
    out.push_back({columns.transpose() * u.z, columns.transpose() * u.covariance * columns});
  }
  return out;
}

}  // namespace imulab::turntable
