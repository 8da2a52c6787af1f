#include "imulab/estimate/turntable_estimator.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/estimate/forward_model.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// How far each column may be from its start: offsets g and 1 rad/s, scales 100 %, misalignments 1e-2, g-sensitivity 1e-3 (rad/s)/(m/s^2), as in
/// the methods without a rig. Decides only what counts as determined.
VectorXd prior_sigma(const SensorModel& nominal) {
  const double accel = 1 / std::cbrt(std::abs(nominal.accel.matrix.determinant())), gyro = 1 / std::cbrt(std::abs(nominal.gyro.matrix.determinant()));
  VectorXd v(Forward::all);
  v.segment<3>(Forward::accel_offset).setConstant(10 * accel);
  v.segment<3>(Forward::gyro_offset).setConstant(gyro);
  for (Index k = 0; k < 9; ++k) {
    const double part = k % 4 == 0 ? 1 : 1e-2;
    v[Forward::accel_matrix + k] = part * accel;
    v[Forward::gyro_matrix + k] = part * gyro;
  }
  v.segment<9>(Forward::gyro_force).setConstant(1e-3 * gyro);
  v.segment<3>(Forward::turning_bias).setConstant(gyro);
  return v;
}

MatrixXd design_matrix(const TableMotion& motion, const VectorXd& truth) {
  MatrixXd x = MatrixXd::Zero(motion.rows(), Forward::all);
  const auto holds = static_cast<Index>(motion.holds()), parts = holds + static_cast<Index>(motion.turns());
  for (Index k = 0; k < parts; ++k) {
    const bool hold = k < holds;
    const double duration = hold ? 1 : motion.end(static_cast<std::size_t>(k)) - motion.begin(static_cast<std::size_t>(k));
    const Vector3d first = truth.segment<3>(6 * k), second = truth.segment<3>(6 * k + 3);
    const Vector3d force = hold ? first : second, rate = hold ? second : first;
    const Index gyro_row = hold ? 6 * k + 3 : 6 * holds + 3 * (k - holds);
    for (Index i = 0; i < 3; ++i) {
      if (hold) {
        x(6 * k + i, Forward::accel_offset + i) = 1;
        x.block<1, 3>(6 * k + i, Forward::accel_matrix + 3 * i) = force.transpose();
      } else {
        x(gyro_row + i, Forward::turning_bias + i) = duration;
      }
      x(gyro_row + i, Forward::gyro_offset + i) = duration;
      x.block<1, 3>(gyro_row + i, Forward::gyro_matrix + 3 * i) = rate.transpose();
      x.block<1, 3>(gyro_row + i, Forward::gyro_force + 3 * i) = -force.transpose();
    }
  }
  return x;
}

/// The readings' linear part alone.
SensorModel without_offsets(SensorModel model) {
  model.accel.offset.setZero();
  model.gyro.offset.setZero();
  return model;
}

/// d readings / d errors of the rig and the site, from d truth / d errors.
MatrixXd reading_jacobian(const TableMotion& motion, const SensorModel& model, const MatrixXd& truth) {
  const SensorModel linear = without_offsets(model);
  MatrixXd out(motion.rows(), truth.cols());
  for (Index c = 0; c < truth.cols(); ++c) out.col(c) = readings(motion, linear, truth.col(c));
  return out;
}

}  // namespace

Matrix3d raw_density(double density, const Matrix3d& matrix) {
  const Matrix3d inverse = matrix.inverse();
  return density * density * inverse * inverse.transpose();
}

TurntableEstimator::TurntableEstimator(const TableMotion& motion, const SensorModel& nominal, const RawNoise& noise,
                                       const TurntableSettings& settings)
    : motion_(motion),
      holds_(motion.holds()),
      parts_(motion.holds() + motion.turns()),
      terms_(settings.terms),
      left_out_(parts_, 0),
      start_(forward(nominal)),
      prior_(prior_sigma(nominal)),
      nominal_errors_(motion.nominal()),
      around_(settings.around.size() > 0 ? settings.around : nominal_errors_),
      truth_(motion.truth(around_)),
      truth_jacobian_(motion.jacobian(around_)) {
  design_ = design_matrix(motion, truth_);
  table_jacobian_ = reading_jacobian(motion, nominal, truth_jacobian_);
  for (const int index : terms_) columns_.push_back(Forward::of(coefficient_table()[static_cast<std::size_t>(index)]));
  if (settings.bias_while_turning && motion.turns() > 0)
    for (Index k = 0; k < 3; ++k) columns_.push_back(Forward::turning_bias + k);

  noise_ = noise_covariance(motion, noise.accel, noise.gyro);
  MatrixXd covariance = noise_;
  weight_ = covariance.diagonal().cwiseSqrt().cwiseInverse();
  for (const std::size_t part : settings.left_out) {
    left_out_[part] = 1;
    if (part < holds_)
      weight_.segment<6>(static_cast<Index>(6 * part)).setZero();
    else
      weight_.segment<3>(static_cast<Index>(6 * holds_ + 3 * (part - holds_))).setZero();
  }
  const VectorXd table_sigma = settings.table_errors ? motion.sigma() : VectorXd::Zero(motion.sigma().size());
  const MatrixXd table = table_jacobian_ * table_sigma.asDiagonal();
  covariance += table * table.transpose();
  covariance = weight_.asDiagonal() * covariance * weight_.asDiagonal();
  for (Index row = 0; row < weight_.size(); ++row)
    if (weight_[row] == 0) covariance(row, row) = 1;
  factor_ = covariance.llt().matrixL();
  const MatrixXd weighted_table = factor_.triangularView<Eigen::Lower>().solve(MatrixXd(weight_.asDiagonal() * table));
  const MatrixXd error_gain =
      table_sigma.asDiagonal() * factor_.triangularView<Eigen::Lower>().transpose().solve(weighted_table).transpose() * weight_.asDiagonal();

  // Normal equations in units of the prior sigmas. Undetermined: data and prior together know it no better than half its prior sigma.
  const auto n = static_cast<Index>(columns_.size());
  const MatrixXd white =
      factor_.triangularView<Eigen::Lower>().solve(MatrixXd(weight_.asDiagonal() * design_(Eigen::all, columns_) * prior_(columns_).asDiagonal()));
  const MatrixXd normal = white.transpose() * white;
  const VectorXd posterior = (normal + MatrixXd::Identity(n, n)).llt().solve(MatrixXd::Identity(n, n)).diagonal();
  std::vector<Index> known, unknown;
  for (Index i = 0; i < n; ++i) (posterior[i] < 0.25 ? known : unknown).push_back(i);
  for (const Index i : known) known_.push_back(columns_[static_cast<std::size_t>(i)]);
  for (const Index i : unknown) unknown_.push_back(columns_[static_cast<std::size_t>(i)]);

  covariance_ = MatrixXd::Zero(Forward::all, Forward::all);
  for (const Index column : unknown_) covariance_(column, column) = prior_[column] * prior_[column];
  gain_.resize(static_cast<Index>(known_.size()), motion.rows());
  white_.resize(motion.rows(), static_cast<Index>(known_.size()));
  if (!known.empty()) {
    const MatrixXd n_kk = normal(known, known);
    const VectorXd diagonal = n_kk.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(diagonal.asDiagonal() * n_kk * diagonal.asDiagonal());
    condition_ = std::sqrt(spectrum.eigenvalues().maxCoeff() / std::max(spectrum.eigenvalues().minCoeff(), 1e-300));
    const Eigen::LLT<MatrixXd> cholesky(n_kk);
    const VectorXd unit_known = prior_(known_), unit_unknown = prior_(unknown_);
    const MatrixXd p_kk = cholesky.solve(MatrixXd::Identity(n_kk.rows(), n_kk.cols()));
    const MatrixXd leak = -p_kk * normal(known, unknown);  // what the undetermined, left at their start, do to the others
    covariance_(known_, known_) = unit_known.asDiagonal() * (p_kk + leak * leak.transpose()) * unit_known.asDiagonal();
    covariance_(known_, unknown_) = unit_known.asDiagonal() * leak * unit_unknown.asDiagonal();
    covariance_(unknown_, known_) = covariance_(known_, unknown_).transpose().eval();
    const MatrixXd half = factor_.triangularView<Eigen::Lower>().transpose().solve(MatrixXd(white(Eigen::all, known)));  // S^-1 x weighted design
    gain_ = unit_known.asDiagonal() * p_kk * half.transpose() * weight_.asDiagonal();
    white_ = white(Eigen::all, known) * unit_known.cwiseInverse().asDiagonal();
  }
  VectorXd held = start_;
  for (const Index column : known_) held[column] = 0;
  base_ = gain_ * (design_ * held);
  error_gain_ = error_gain - (error_gain * design_(Eigen::all, known_)) * gain_;
  error_base_ = nominal_errors_ - error_gain * (design_ * held - design_(Eigen::all, known_) * base_);
}

MatrixXd TurntableEstimator::solve(const MatrixXd& readings) const {
  MatrixXd v = start_.replicate(1, readings.cols());
  v(known_, Eigen::all) = (gain_ * readings).colwise() - base_;
  return v;
}

SensorModel TurntableEstimator::estimate(const VectorXd& readings) const { return backward(solve(readings)); }

VectorXd TurntableEstimator::table_errors(const VectorXd& readings) const { return error_base_ + error_gain_ * readings; }

MatrixXd TurntableEstimator::linearised(const MatrixXd& measured) const {
  const VectorXd shift = table_jacobian_ * (around_ - nominal_errors_);
  const MatrixXd first_order = measured.colwise() + shift;
  const MatrixXd errors = (error_gain_ * first_order).colwise() + error_base_, columns = solve(first_order);
  MatrixXd out = measured;
  out.noalias() += table_jacobian_ * (errors.colwise() - nominal_errors_);
  for (Index run = 0; run < measured.cols(); ++run)
    out.col(run) -= readings(motion_, without_offsets(backward(columns.col(run))), motion_.truth(errors.col(run)) - truth_);
  return out;
}

TurntableEstimator::Uncertainty TurntableEstimator::uncertainty(const SensorModel& at) const {
  const MatrixXd derivatives = backward_derivatives(at, terms_);
  const MatrixXd covariance = derivatives * covariance_ * derivatives.transpose();
  VectorXd prior = VectorXd::Zero(Forward::all);
  prior(columns_) = prior_(columns_);
  const VectorXd before = (derivatives * prior.asDiagonal()).rowwise().squaredNorm();
  Uncertainty out;
  std::vector<Index> kept;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const bool determined = covariance(row, row) < 0.25 * before[row];
    (determined ? out.determined : out.undetermined).push_back(terms_[i]);
    if (determined) kept.push_back(row);
  }
  out.covariance = covariance(kept, kept);
  return out;
}

MatrixXd TurntableEstimator::sensitivity(const SensorModel& at, const std::vector<int>& coefficients) const {
  return backward_derivatives(at, coefficients)(Eigen::all, known_) * gain_;
}

VectorXd TurntableEstimator::whitened_residual(const VectorXd& readings) const {
  return factor_.triangularView<Eigen::Lower>().solve(VectorXd(weight_.cwiseProduct(readings - design_ * solve(readings))));
}

double TurntableEstimator::chi2(const VectorXd& readings) const { return whitened_residual(readings).squaredNorm(); }

int TurntableEstimator::degrees_of_freedom() const { return static_cast<int>((weight_.array() > 0).count()) - static_cast<int>(known_.size()); }

std::vector<double> TurntableEstimator::log_probabilities(const VectorXd& readings) const {
  // z = S^-1 residual, with covariance B = S^-1 - S^-1 X P X^T S^-1. Leaving rows out lowers chi-square by z^T B^-1 z of these rows.
  const MatrixXd inverse = factor_.triangularView<Eigen::Lower>().solve(MatrixXd::Identity(factor_.rows(), factor_.cols()));
  const VectorXd z = inverse.transpose() * whitened_residual(readings);
  const MatrixXd projected = inverse.transpose() * white_;
  const MatrixXd b = inverse.transpose() * inverse - projected * (white_.transpose() * white_).llt().solve(projected.transpose());
  std::vector<double> out(parts_, 0.0);
  for (std::size_t k = 0; k < parts_; ++k) {
    if (left_out_[k]) continue;
    const Index first = k < holds_ ? static_cast<Index>(6 * k) : static_cast<Index>(6 * holds_ + 3 * (k - holds_)), size = k < holds_ ? 6 : 3;
    // In the part's own units, where 1 is the variance of an unfitted residual: 0 where the fit follows it whatever it is.
    const MatrixXd own = inverse.middleCols(first, size);
    const Eigen::LLT<MatrixXd> unit(own.transpose() * own);
    const MatrixXd left = unit.matrixL().solve(b.block(first, first, size, size));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(MatrixXd(unit.matrixL().solve(left.transpose())));
    const VectorXd along = spectrum.eigenvectors().transpose() * unit.matrixL().solve(z.segment(first, size));
    double statistic = 0, degrees = 0;
    for (Index i = 0; i < size; ++i) {
      if (spectrum.eigenvalues()[i] < 1e-6) continue;
      statistic += along[i] * along[i] / spectrum.eigenvalues()[i];
      degrees += 1;
    }
    if (degrees > 0) out[k] = log_chi_square_tail(statistic, degrees);
  }
  return out;
}

}  // namespace imulab
