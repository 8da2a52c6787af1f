// The second order of the table's errors in an estimate.
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/rig/table_readings.hpp"

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Let d be the table's errors, d^ their estimates, dv the first-order errors of the forward model's columns, t the truth, J and T its first and
/// second derivatives by d, and M the model. Linearized readings differ from a linear model by
///   q = M (T(d, d) - T(d^, d^)) / 2 - dM J d^
/// and a coefficient c(v) by  c' gain q + c''(dv, dv) / 2: a quadratic form of normal variables, z^T Q z / 2 with z = (d, d^, dv).
Estimator::SecondOrder Estimator::second_order(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const {
  const Index sources = table(), size = 2 * sources + Forward::all;
  MatrixXd column_gain = MatrixXd::Zero(Forward::all, motion_.rows());
  column_gain(known_, Eigen::all) = gain_;

  // The covariance of z has a part from the table's errors, and a part from noise and effects.
  const MatrixXd by_effects = readings_by_effects() * effects_sigma().asDiagonal();
  MatrixXd by_errors(size, sources), by_noise(size, motion_.rows());
  by_errors << MatrixXd::Identity(sources, sources), error_gain_.topRows(sources) * readings_by_table(), column_gain * readings_by_table();
  by_noise << MatrixXd::Zero(sources, motion_.rows()), error_gain_.topRows(sources), column_gain;
  by_errors *= source_sigma_.head(sources).asDiagonal();
  const MatrixXd covariance = by_errors * by_errors.transpose() + by_noise * (noise_ + by_effects * by_effects.transpose()) * by_noise.transpose();

  const MatrixXd weights = backward_derivatives(at, coefficients) * column_gain;
  const std::vector<MatrixXd> table = motion_.curvatures(around_, by_truth(motion_, at, weights));
  const std::vector<MatrixXd> model = backward_curvatures(at, coefficients, prior_);
  SecondOrder out{VectorXd(static_cast<Index>(coefficients.size())), MatrixXd(coefficients.size(), coefficients.size())};
  std::vector<MatrixXd> products;  // Q x covariance
  for (std::size_t c = 0; c < coefficients.size(); ++c) {
    const auto row = static_cast<Index>(c);
    const MatrixXd mixed = -mixed_curvature(motion_, truth_by_table_, weights.row(row));
    MatrixXd product(size, size);
    product.topRows(sources) = table[c] * covariance.topRows(sources);
    product.middleRows(sources, sources) =
        mixed.transpose() * covariance.bottomRows(Forward::all) - table[c] * covariance.middleRows(sources, sources);
    product.bottomRows(Forward::all) = mixed * covariance.middleRows(sources, sources) + model[c] * covariance.bottomRows(Forward::all);
    products.push_back(std::move(product));
    out.bias[row] = 0.5 * products.back().trace();
    for (std::size_t other = 0; other <= c; ++other) {
      const double shared = 0.5 * products[c].cwiseProduct(products[other].transpose()).sum();
      out.covariance(row, static_cast<Index>(other)) = out.covariance(static_cast<Index>(other), row) = shared;
    }
  }
  return out;
}

}  // namespace imulab::turntable
