// The problem. A procedure gives readings y: the mean of each hold, and the sum of each turn. In the forward model (calibrated -> raw), readings are
// linear in its columns v (offsets and matrices) and, to first order, in the table's errors e, which many readings share:
//
//     y = X v + T e + n,   e ~ (0, Sigma) as declared, n ~ (0, R) the sensors' noise.
//
// The best linear estimate weights by S = R + T Sigma T^T: v = (X^T S^-1 X)^-1 X^T S^-1 y. X, T and S depend only on the procedure, so everything but
// the last product with y is computed once: a Monte Carlo run costs one product of a matrix and a vector.
//
// Zhang 2010 is the same estimate with equal weights for his procedure, in which X^T X is diagonal and the sums can be written explicitly:
// - eq 6: n turns forward and back about body axis j give the column j of the gyros' forward matrix, (N+ - N-) / (4 pi n). `backward` inverts the
// matrix;
// - eq 9: the gyro offset is the mean over 24 positions;
// - eq 10: a face up and the face down give the column (N_up - N_down) / 2g of the accelerometers' forward matrix; the mean of six faces is
//   the offset. His eqs 8, 12 and 13 are the errors of these estimates due to the table. Here they are the product gain * T for any procedure
//   (prediction.cpp), which the tests compare with his expressions. S differs from equal weights if readings share table errors.
//
// A small example. One accelerometer with the forward model y = k f + b is held up and down. Each mean has noise r, and g has the common relative
// uncertainty s:
//
//     y1 = k g + b + k g e + n1
//     y2 = -k g + b - k g e + n2        S = r^2 I + s^2 k^2 g^2 [1 -1; -1 1]
//
// Two readings and two unknowns: k = (y1 - y2) / 2g and b = (y1 + y2) / 2 for any weights. But their variances differ: r^2 / 2g^2 + k^2 s^2 for k,
// which is as uncertain as g, and r^2 / 2 for b, which does not depend on g. With r = 1 ug and a table tilt of 2 arcsec (10 ug across), a side hold
// demonstrates the other use of S: its weight for the offset is a hundredth of an upright hold's.
//
// The difficulties:
// - T Sigma T^T may be 1e10 times R. Sums of squares would lose R, and with it all information beyond the table; orthogonal factors keep it
//   (set_weights).
// - Readings are 1e6 times the relevant differences: the gain is applied to differences from the expected readings (set_gains).
// - Columns that a procedure does not determine keep their start and are considered; optional terms have priors that act as observations.
// - Products of table errors with each other and with the model's errors are of second order: `linearized` removes their observable part,
//   second_order.cpp states the rest.
#include "imulab/estimate/turntable/estimator.hpp"

#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/rig/table_readings.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// One sigma of the coefficients about the start, so wide that it only defines which coefficients count as determined: those known to half of it.
constexpr kernel::PriorSizes prior_sizes{
    .accel = {.offset = 10, .scale = 1, .misalignment = 1e-2}, .gyro = {.offset = 1, .scale = 1, .misalignment = 1e-2}, .g_sensitivity = 1e-3};
constexpr double needed_part = 0.5;
/// An optional term is estimated if its sigma is below this fraction of its prior sigma; otherwise it is not observable.
constexpr double needed_part_of_optional = 0.9;

/// Returns one sigma of the forward model's columns, raw.
VectorXd prior_sigmas(const SensorModel& nominal, const std::optional<kernel::PriorSizes>& optional) {
  const auto raw_per_unit = [](const Matrix3d& matrix) { return 1 / std::cbrt(std::abs(matrix.determinant())); };
  const double accel = raw_per_unit(nominal.accel.matrix), gyro = raw_per_unit(nominal.gyro.matrix);
  VectorXd v = VectorXd::Zero(Forward::all);
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& c = coefficient(index);
    const Matrix3d& matrix = triad_model(nominal, c.triad).matrix;
    const kernel::PriorSizes& sizes = is_optional(c.term) ? optional.value_or(prior_sizes) : prior_sizes;
    if (c.term == Term::offset || c.term == Term::matrix || c.term == Term::g_sensitivity)
      v[Forward::of(c)] = kernel::prior_sigma(sizes, c, 1) * (c.triad == Triad::accel ? accel : gyro);
    else if (c.term == Term::quadratic || c.term == Term::cubic)
      v[Forward::of(c)] = kernel::prior_sigma(sizes, c, matrix.row(c.row).norm());
  }
  v.segment<3>(Forward::turning_bias) = v.segment<3>(Forward::gyro_offset);
  return v;
}

bool is_among(const std::vector<Index>& places, Index place) { return std::find(places.begin(), places.end(), place) != places.end(); }

bool of_site(const ErrorSource& source) {
  return source.kind == ErrorSource::Kind::gravity || source.kind == ErrorSource::Kind::latitude || source.kind == ErrorSource::Kind::earth;
}

/// Scales the sigmas of the table's errors; those of the site stay as declared.
VectorXd sigma_of_table(const TableMotion& motion, double factor) {
  VectorXd sigma = motion.sigma();
  for (Index k = 0; k < sigma.size(); ++k)
    if (!of_site(motion.sources()[static_cast<std::size_t>(k)])) sigma[k] *= factor;
  return sigma;
}

/// Effects are outputs without a force or rate: an accelerometer effect does not act on the gyros.
MatrixXd changes_by_effects(const TableMotion& motion, SensorModel nominal, const TableEffects& effects) {
  nominal.g_sensitivity.setZero();
  return reading_changes(motion, nominal, effects.truth);
}

MatrixXd noise_of(const TableMotion& motion, const RawNoise& noise, const Enlargement& by) {
  const Eigen::Matrix<double, 6, 1> factor{by.accel, by.accel, by.accel, by.gyro, by.gyro, by.gyro};
  MatrixXd out = noise_covariance(motion, noise.accel, noise.gyro);
  if (noise.slow.size() > 0) out += noise.slow;
  const VectorXd of_rows = (by_bias(motion).array() != 0).cast<double>().matrix() * factor;
  return of_rows.asDiagonal() * out * of_rows.asDiagonal();
}

}  // namespace

Matrix3d raw_density(double density, const Matrix3d& matrix) {
  const Matrix3d inverse = matrix.inverse();
  return density * density * inverse * inverse.transpose();
}

Estimator::Estimator(const TableMotion& motion, const SensorModel& nominal, const RawNoise& noise, const EstimatorOptions& options)
    : motion_(motion),
      effect_groups_(options.effects.table.groups()),
      terms_(options.terms),
      start_(forward(nominal)),
      prior_(prior_sigmas(nominal, options.optional)),
      source_sigma_(motion.sources().size() + static_cast<std::size_t>(options.effects.table.size())),
      nominal_errors_(motion.nominal()),
      around_(options.around.size() > 0 ? options.around : nominal_errors_),
      truth_(motion.truth(around_)),
      truth_by_table_(motion.jacobian(around_)),
      readings_by_source_(motion.rows(), source_sigma_.size()),
      design_(by_forward_columns(motion, nominal, truth_)),
      noise_(noise_of(motion, noise, options.enlarged)) {
  source_sigma_ << sigma_of_table(motion, options.enlarged.table), options.effects.table.sigma();
  readings_by_source_ << reading_changes(motion, nominal, truth_by_table_), changes_by_effects(motion, nominal, options.effects);
  for (const CoefficientIndex index : terms_) {
    columns_.push_back(Forward::of(coefficient(index)));
    if (options.optional && is_optional(coefficient(index).term)) optional_.push_back(columns_.back());
  }
  start_(optional_).setZero();
  if (options.bias_while_turning && motion.turns() > 0)
    for (Index k = 0; k < 3; ++k) columns_.push_back(Forward::turning_bias + k);
  set_weights(options);
  set_gains(options.all_optional);
}

/// Weights by the covariance of the readings S = R + T T^T, T = J diag(sigma), in units of the noise; and computes the table's errors from the
/// readings, sigma T^T S^-1. With R = L L^T, [T^T; L^T] = Q U gives S = U^T U and T^T S^-1 = Q_T U^-T. A sum of squares would lose noise that is far
/// below the table's errors.
void Estimator::set_weights(const EstimatorOptions& options) {
  weight_ = noise_.diagonal().cwiseSqrt().cwiseInverse();
  for (const std::size_t part : options.left_out) weight_.segment(motion_.row(part), motion_.size(part)).setZero();
  const VectorXd sigma = options.table_errors ? source_sigma_ : VectorXd::Zero(source_sigma_.size());
  MatrixXd noise = weight_.asDiagonal() * noise_ * weight_.asDiagonal();
  for (Index row = 0; row < weight_.size(); ++row)
    if (weight_[row] == 0) noise(row, row) = 1;
  MatrixXd root(sigma.size() + weight_.size(), weight_.size());
  root << (weight_.asDiagonal() * readings_by_source_ * sigma.asDiagonal()).transpose(), Cholesky(noise).lower().transpose();
  const OrthogonalTriangular factors = orthogonal_triangular(root);
  factor_ = Cholesky::of_lower(factors.R.transpose());
  const MatrixXd of_sources = factors.Q.topRows(sigma.size());
  error_gain_ = sigma.asDiagonal() * factor_.solve_upper(MatrixXd(of_sources.transpose())).transpose() * weight_.asDiagonal();
}

MatrixXd Estimator::whitened(const MatrixXd& readings) const { return factor_.solve_lower(MatrixXd(weight_.asDiagonal() * readings)); }

/// x = start + (X^T S^-1 X + prior)^-1 X^T S^-1 (y - X start) for the columns that the readings determine; the others keep their start and are
/// considered. The gain has a relative error of about 1e-12, so it is applied to differences from expected readings: applied to g itself, it would
/// bring that error into the coefficients. Columns with a prior start at its mean, zero.
void Estimator::set_gains(bool all_optional) {
  const MatrixXd white = whitened(design_(Eigen::all, columns_));
  const VectorXd none = VectorXd::Zero(white.rows());
  kernel::Parameters parameters(white.cols());
  parameters.sigma = prior_(columns_);
  VectorXd part = VectorXd::Constant(Forward::all, needed_part), kept_prior = VectorXd::Constant(Forward::all, kernel::no_prior);
  part(optional_).setConstant(all_optional ? kernel::no_prior : needed_part_of_optional);
  kept_prior(optional_) = prior_(optional_);
  const VectorXd wanted = part(columns_).cwiseProduct(parameters.sigma);
  const std::vector<Index> open = kernel::undetermined(kernel::solve(white, none, parameters).covariance, parameters, wanted);
  parameters.sigma = kept_prior(columns_);
  for (const Index i : open) parameters.role[static_cast<std::size_t>(i)] = kernel::Role::fixed;
  const std::vector<Index> known = parameters.with(kernel::Role::estimated);
  const std::string_view what = "the holds and turns";
  free_covariance_ = kernel::solve(white, none, parameters, what).covariance(known, known);
  const MatrixXd gain = kernel::gain(white, parameters, what)(known, Eigen::all);
  if (!known.empty()) condition_ = kernel::condition_number(white, parameters);
  for (const Index i : open) {
    parameters.role[static_cast<std::size_t>(i)] = kernel::Role::considered;
    parameters.sigma[i] = prior_[columns_[static_cast<std::size_t>(i)]];
  }
  covariance_ = MatrixXd::Zero(Forward::all, Forward::all);
  covariance_(columns_, columns_) = kernel::solve(white, none, parameters, what).covariance;

  for (const Index i : known) known_.push_back(columns_[static_cast<std::size_t>(i)]);
  white_ = white(Eigen::all, known);
  gain_ = factor_.solve_upper(MatrixXd(gain.transpose())).transpose() * weight_.asDiagonal();
  expected_ = design_ * start_;
  error_gain_ -= (error_gain_ * design_(Eigen::all, known_)) * gain_;
}

MatrixXd Estimator::solve(const MatrixXd& readings) const {
  MatrixXd v = start_.replicate(1, readings.cols());
  v(known_, Eigen::all) += gain_ * (readings.colwise() - expected_);
  return v;
}

SensorModel Estimator::estimate(const VectorXd& readings) const { return backward(solve(readings)); }

VectorXd Estimator::table_errors(const VectorXd& readings) const { return nominal_errors_ + error_gain_.topRows(table()) * (readings - expected_); }

MatrixXd Estimator::linearized(const MatrixXd& measured) const {
  const VectorXd shift = readings_by_table() * (around_ - nominal_errors_);
  const MatrixXd first_order = measured.colwise() + shift;
  const MatrixXd errors = (error_gain_.topRows(table()) * (first_order.colwise() - expected_)).colwise() + nominal_errors_,
                 columns = solve(first_order);
  MatrixXd out = measured;
  out.noalias() += readings_by_table() * (errors.colwise() - nominal_errors_);
  for (Index run = 0; run < measured.cols(); ++run)
    out.col(run) -= reading_changes(motion_, backward(columns.col(run)), motion_.truth(errors.col(run)) - truth_);
  return out;
}

Estimator::Uncertainty Estimator::uncertainty(const SensorModel& at) const {
  const MatrixXd derivatives = backward_derivatives(at, terms_), asked = derivatives(Eigen::all, columns_);
  const MatrixXd covariance = derivatives * covariance_ * derivatives.transpose();
  const VectorXd before = (asked * prior_(columns_).asDiagonal()).rowwise().norm();
  kernel::Parameters parameters(covariance.rows());
  const std::vector<Index> open = kernel::undetermined(covariance, parameters, needed_part * before);
  Uncertainty out;
  std::vector<Index> stated;
  for (Index i = 0; i < std::ssize(terms_); ++i) {
    const CoefficientIndex index = terms_[static_cast<std::size_t>(i)];
    const Index column = Forward::of(coefficient(index));
    const bool optional = is_among(optional_, column);
    if (!optional && is_among(open, i)) {
      out.undetermined.push_back(index);
      continue;
    }
    if (optional && !is_among(known_, column)) out.considered.push_back(index);
    out.stated.push_back(index);
    stated.push_back(i);
  }
  out.covariance = covariance(stated, stated);
  return out;
}

MatrixXd Estimator::by_prior(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients,
                             const std::vector<CoefficientIndex>& terms) const {
  std::vector<Index> columns;
  for (const CoefficientIndex index : terms) columns.push_back(Forward::of(coefficient(index)));
  MatrixXd error = MatrixXd::Zero(Forward::all, std::ssize(columns));  // errors of the columns: estimate minus truth
  error(known_, Eigen::all) = gain_ * design_(Eigen::all, columns);
  for (std::size_t k = 0; k < columns.size(); ++k) error(columns[k], static_cast<Index>(k)) -= 1;
  return backward_derivatives(at, coefficients) * error * prior_(columns).asDiagonal();
}

VectorXd Estimator::optional_sigma() const {
  VectorXd out = VectorXd::Zero(prior_.size());
  out(optional_) = prior_(optional_);
  return out;
}

VectorXd Estimator::prior_sigma(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const {
  return (backward_derivatives(at, coefficients)(Eigen::all, optional_) * prior_(optional_).asDiagonal()).rowwise().norm();
}

MatrixXd Estimator::sensitivity(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const {
  return backward_derivatives(at, coefficients)(Eigen::all, known_) * gain_;
}

double Estimator::chi2(const VectorXd& readings) const {
  const VectorXd columns = solve(readings), sigma = prior_(optional_);
  return whitened(readings - design_ * columns).squaredNorm() + columns(optional_).cwiseQuotient(sigma).squaredNorm();
}

/// Each term with a prior counts as one observation of itself.
int Estimator::degrees_of_freedom() const {
  const auto free = std::count_if(known_.begin(), known_.end(), [&](Index column) { return !is_among(optional_, column); });
  return static_cast<int>((weight_.array() > 0).count()) - static_cast<int>(free);
}

Estimator::Unexplained Estimator::unexplained(const VectorXd& readings) const {
  const MatrixXd inverse = factor_.solve_lower(MatrixXd::Identity(weight_.size(), weight_.size()));
  const MatrixXd projected = inverse.transpose() * white_;
  Unexplained out{inverse.transpose() * whitened(readings - design_ * solve(readings)), {}, inverse.transpose() * inverse};
  out.covariance = out.unfitted - projected * free_covariance_ * projected.transpose();
  return out;
}

std::vector<double> Estimator::log_probabilities(const VectorXd& readings) const {
  // Leaving rows out lowers chi-square by z^T B^-1 z of these rows.
  const auto [z, covariance, unfitted] = unexplained(readings);
  std::vector<double> out;
  for (std::size_t k = 0; k < motion_.parts(); ++k) {
    const Index row = motion_.row(k), size = motion_.size(k);
    out.push_back(weight_[row] == 0
                      ? 0
                      : kernel::deviation(z.segment(row, size), covariance.block(row, row, size, size), unfitted.block(row, row, size, size))
                            .log_probability());
  }
  return out;
}

Vector3d Estimator::variance_ratios(const VectorXd& readings) const {
  const Unexplained u = unexplained(readings);
  const VectorXd accel = (by_bias(motion_).leftCols<3>().array() != 0).cast<double>().rowwise().sum();
  VectorXd of_table = source_sigma_.head(table());
  for (Index k = 0; k < of_table.size(); ++k)
    if (of_site(motion_.sources()[static_cast<std::size_t>(k)])) of_table[k] = 0;
  const MatrixXd noise = weight_.asDiagonal() * noise_ * weight_.asDiagonal(),
                 table = weight_.asDiagonal() * readings_by_table() * of_table.asDiagonal();
  const auto ratio = [&](const MatrixXd& variance) { return u.z.dot(variance * u.z) / u.covariance.cwiseProduct(variance).sum(); };
  const VectorXd gyro = VectorXd::Ones(accel.size()) - accel;
  return {ratio(accel.asDiagonal() * noise * accel.asDiagonal()), ratio(gyro.asDiagonal() * noise * gyro.asDiagonal()),
          ratio(table * table.transpose())};
}

std::vector<double> Estimator::part_residuals(const VectorXd& readings) const {
  const MatrixXd by_sources = readings_by_source_ * source_sigma_.asDiagonal();
  const VectorXd variance = noise_.diagonal() + by_sources.rowwise().squaredNorm();
  const VectorXd square = (readings - design_ * solve(readings)).cwiseAbs2().cwiseQuotient(variance);
  std::vector<double> out;
  for (std::size_t k = 0; k < motion_.parts(); ++k) out.push_back(std::sqrt(square.segment(motion_.row(k), motion_.size(k)).mean()));
  return out;
}

}  // namespace imulab::turntable
