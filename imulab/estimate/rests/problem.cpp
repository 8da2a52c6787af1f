#include "imulab/estimate/rests/problem.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/model/frame.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

Matrix3d mean_covariance(const TriadModel& model, const Vector3d& sample_sigma, const Vector3d& rounding, std::size_t samples, double spread) {
  const Vector3d variance = sample_sigma.cwiseAbs2() / static_cast<double>(samples) + rounding.cwiseAbs2();
  return model.matrix * variance.asDiagonal() * model.matrix.transpose() + spread * spread * Matrix3d::Identity();
}

/// Iterations that pass a scale near zero would find no noise there, and stay.
TriadModel with_half_the_scale_at_least(TriadModel model, const TriadModel& prior) {
  for (int k = 0; k < 3; ++k) {
    const double norm = model.matrix.row(k).norm(), least = 0.5 * prior.matrix.row(k).norm();
    if (norm > 0 && norm < least) model.matrix.row(k) *= least / norm;
  }
  return model;
}

SampleNoise scaled(const SampleNoise& raw, const Scaling& scaling) {
  return {raw.accel.cwiseQuotient(scaling.accel_scale), raw.gyro.cwiseQuotient(scaling.gyro_scale)};
}

/// The factor of a coefficient in the sensor model.
double input_of(const Coefficient& c, const Vector3d& reading, const Vector3d& force) {
  if (c.term == Term::g_sensitivity) return force[c.column];
  if (c.term == Term::matrix) return reading[c.column];
  return c.term == Term::offset ? 1 : std::pow(reading[c.row], c.term == Term::quadratic ? 2 : 3);
}

bool bends_far_from_zero(const Coefficient& c, const Scaling& scaling) {
  if (c.term != Term::quadratic && c.term != Term::cubic) return false;
  const bool accel = c.triad == Triad::accel;
  const Vector3d zero = (accel ? scaling.accel_center : scaling.gyro_center).cwiseQuotient(accel ? scaling.accel_scale : scaling.gyro_scale);
  return zero.cwiseAbs().maxCoeff() > 1;  // in half ranges
}

/// Priors of the optional terms by the declaration, or by the offsets at zero readings. Readings in counts may have their zero anywhere: offsets
/// beyond those of any IMU are that, and tell nothing.
kernel::PriorSizes expected_terms(const coarse::RestStart& start, const Session& session) {
  const SensorModel raw = to_raw(start.model, start.scaling);
  // MEMS sensors, the least that counts can be of without a grade; the limits are those of the offsets' priors.
  const auto plausible = [](const Vector3d& offset, double limit, double usual) {
    return offset.cwiseAbs().maxCoeff() < limit ? offset : Vector3d(Vector3d::Constant(usual));
  };
  return kernel::optional_priors(session.imu, plausible(raw.accel.offset, 0.2 * session.site.gravity(), 0.03 * unit::g),
                                 plausible(raw.gyro.offset, 1.0, 1 * unit::deg));
}

}  // namespace

std::vector<CoefficientIndex> static_coefficients(bool with_gyros) {
  std::vector<CoefficientIndex> out = select_each({"accel.offset", "accel.matrix", "accel.quadratic", "accel.cubic"});
  std::erase_if(out, zero_by_frame);
  if (!with_gyros) return out;
  // Earth's rate is far too small to show their nonlinearity.
  for (const CoefficientIndex index : select_each({"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})) out.push_back(index);
  return out;
}

std::vector<CoefficientIndex> handheld_coefficients() {
  std::vector<CoefficientIndex> out = static_coefficients(true);
  for (const CoefficientIndex index : select_each({"gyro.quadratic", "gyro.cubic"})) out.push_back(index);
  return out;
}

std::vector<CoefficientIndex> choose_coefficients(coarse::RestStart& start, const Session& session, const std::vector<CoefficientIndex>& wanted,
                                                  const std::vector<CoefficientIndex>& supplied, std::string_view method) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(wanted, supplied, method);
  start.terms = expected_terms(start, session);
  start.named = !wanted.empty();
  for (const CoefficientIndex index : supplied) {
    if (contains(chosen, index)) continue;
    const Coefficient& c = coefficient(index);
    const bool counts = triad_model(start.prior, c.triad).raw_unit == "count";
    if (counts && (c.term == Term::offset || is_scale(c)))
      throw TermsError(fmt::format("{} is not among the terms to estimate: readings in counts have no offset and scale to start from", c.name));
    set_coefficient(start.model, index, coefficient_value(start.prior, index));
  }
  return chosen;
}

RestProblem::RestProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices)
    : rests_(start.rests),
      gravity_(site.gravity()),
      relative_gravity_sigma_(site.gravity_sigma() / gravity_),
      latitude_(site.latitude),
      scaling_(start.scaling),
      noise_{scaled(start.means.sample, scaling_), scaled(start.means.rounding, scaling_), scaled(start.means.step, scaling_)},
      model_(start.model),
      prior_(start.prior),
      sizes_(start.terms),
      indices_(std::move(indices)),
      roles_(indices_.size(), kernel::Role::estimated) {
  sizes_.accel.offset = 0.2 * gravity_, sizes_.gyro.offset = 1.0;
  for (kernel::TriadPrior* triad : {&sizes_.accel, &sizes_.gyro}) triad->scale = 0.2, triad->misalignment = 1e-2;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    unstated_.push_back(!start.named && bends_far_from_zero(coefficient(indices_[i]), scaling_));
    if (unstated_.back()) roles_[i] = kernel::Role::considered;
  }
}

double RestProblem::prior_sigma(const Coefficient& c) const {
  kernel::PriorSizes sizes = sizes_;
  const auto row = triad_model(prior_, c.triad).matrix.row(c.row);
  if (std::abs(row[c.row]) <= 0.9 * row.norm()) sizes.accel.misalignment = sizes.gyro.misalignment = 0.2;
  return kernel::prior_sigma(sizes, c, row.norm());
}

kernel::Parameters RestProblem::parameters(Index nuisances) const {
  kernel::Parameters out(std::ssize(indices_) + nuisances);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    out.role[i] = roles_[i];
    out.offset[static_cast<Index>(i)] = coefficient_value(prior_, indices_[i]) - coefficient_value(model_, indices_[i]);
    out.sigma[static_cast<Index>(i)] = prior_sigma(coefficient(indices_[i]));
  }
  return out;
}

std::vector<Index> RestProblem::unseen_terms(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const {
  constexpr double nothing = 0.9;  // of the prior sigma: the data say less than a quarter of what the prior says
  std::vector<Index> unseen;
  for (const Index i : parameters.with(kernel::Role::estimated))
    if (i < std::ssize(indices_) && is_optional(coefficient(indices_[static_cast<std::size_t>(i)]).term) &&
        !(std::sqrt(covariance(i, i)) <= nothing * parameters.sigma[i]))
      unseen.push_back(i);
  return unseen;
}

std::vector<Index> RestProblem::runaway_gyro_matrix(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const {
  constexpr double away = 2;  // prior sigmas
  std::vector<Index> matrix;
  bool runaway = false;
  for (const Index i : parameters.with(kernel::Role::estimated)) {
    if (i >= std::ssize(indices_)) continue;
    const Coefficient& c = coefficient(indices_[static_cast<std::size_t>(i)]);
    if (c.triad != Triad::gyro || (c.term != Term::matrix && c.term != Term::quadratic && c.term != Term::cubic)) continue;
    matrix.push_back(i);
    if (!is_scale(c)) continue;
    const CoefficientIndex index = indices_[static_cast<std::size_t>(i)];
    const bool known = std::sqrt(covariance(i, i)) < kernel::needed_sigma(c, parameters.sigma[i]);
    runaway = runaway || (!known && std::abs(coefficient_value(model_, index) - coefficient_value(prior_, index)) > away * parameters.sigma[i]);
  }
  return runaway ? matrix : std::vector<Index>{};
}

bool RestProblem::widen_priors(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) {
  const auto n = std::ssize(indices_);
  VectorXd moved = coefficient_values(model_, indices_) - coefficient_values(prior_, indices_);
  for (Index i = 0; i < n; ++i)
    if (roles_[static_cast<std::size_t>(i)] != kernel::Role::estimated) moved[i] = 0;
  const std::vector<std::string> names = kernel::widen_priors(sizes_, indices_, moved, parameters.sigma.head(n), covariance.topLeftCorner(n, n));
  for (const std::string& name : names)
    if (std::find(widened_.begin(), widened_.end(), name) == widened_.end()) widened_.push_back(name);
  return !names.empty();
}

VectorXd RestProblem::longest_step(Index nuisances) const {
  VectorXd longest = VectorXd::Constant(std::ssize(indices_) + nuisances, kernel::no_prior);
  for (std::size_t i = 0; i < indices_.size(); ++i)
    if (const Coefficient& c = coefficient(indices_[i]); !is_optional(c.term)) longest[static_cast<Index>(i)] = prior_sigma(c);
  return longest;
}

void RestProblem::hold(const std::vector<Index>& unseen) {
  for (const Index i : unseen) roles_[static_cast<std::size_t>(i)] = kernel::Role::considered;
}

void RestProblem::release() {
  for (std::size_t i = 0; i < roles_.size(); ++i) roles_[i] = unstated_[i] ? kernel::Role::considered : kernel::Role::estimated;
}

void RestProblem::correct(const VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
}

Vector3d RestProblem::rate_at(const RestMeans& rest) const {
  return output(model_.gyro, scaling_.gyro(rest.gyro)) + model_.g_sensitivity * force_at(rest);
}

Matrix3d RestProblem::force_covariance(const RestMeans& rest, double spread) const {
  return mean_covariance(model_.accel, noise_.sample.accel, noise_.rounding.accel, rest.range.size(), spread);
}

Matrix3d RestProblem::rate_covariance(const RestMeans& rest, double spread) const {
  return mean_covariance(with_half_the_scale_at_least(model_.gyro, prior_.gyro), noise_.sample.gyro, noise_.rounding.gyro, rest.range.size(), spread);
}

void RestProblem::add_derivatives(Conditions& c, Index row, Triad triad, const RestMeans& rest, const Eigen::MatrixXd& by_output) const {
  const Vector3d reading = triad == Triad::accel ? scaling_.accel(rest.accel) : scaling_.gyro(rest.gyro), force = force_at(rest);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != triad) continue;
    c.jacobian.col(static_cast<Index>(i)).segment(row, by_output.rows()) += input_of(term, reading, force) * by_output.col(term.row);
  }
}

std::vector<SuspectRows> RestProblem::suspects(const Conditions& conditions) const {
  std::vector<SuspectRows> all;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    SuspectRows& suspect =
        all.emplace_back(SuspectRows{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}, rests_[k].begin_s, rests_[k].end_s});
    const CovarianceBlock& block = conditions.blocks[k];
    for (Index row = block.first; row < block.first + block.size; ++row) suspect.rows.push_back(row);
  }
  return all;
}

using Eigen::MatrixXd;

StaticProblem::StaticProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices, bool with_gyros)
    : RestProblem(start, site, std::move(indices)), with_gyros_(with_gyros) {}

Conditions StaticProblem::conditions(const Spreads& spreads) const {
  const Index per_rest = with_gyros_ ? 3 : 1, rests = static_cast<Index>(rests_.size());
  Conditions c(per_rest * rests, static_cast<Index>(indices_.size()));
  for (Index k = 0; k < rests; ++k) add_rest(c, per_rest * k, rests_[static_cast<std::size_t>(k)], spreads);
  return c;
}

void StaticProblem::add_rest(Conditions& c, Index row, const RestMeans& rest, const Spreads& spreads) const {
  const Index rows = with_gyros_ ? 3 : 1;
  const Vector3d force = force_at(rest), up = force.normalized();
  // The derivatives of the rest's rows by its force and by its rate.
  MatrixXd rows_by_force = MatrixXd::Zero(rows, 3), rows_by_rate = MatrixXd::Zero(rows, 3);
  rows_by_force.row(0) = up.transpose();
  c.value[row] = force.norm() - gravity_;
  Matrix3d rate_noise = Matrix3d::Zero();
  if (with_gyros_) {
    const Vector3d rate = rate_at(rest);
    const double vertical = up.dot(rate);
    const Vector3d across = rate - vertical * up, north = across.normalized(), east = north.cross(up);
    const Matrix3d turn_up = direction_derivative(force);
    rate_noise = rate_covariance(rest, spreads[1]);
    rows_by_rate.row(1) = up.transpose();
    rows_by_force.row(1) = rate.transpose() * turn_up;
    rows_by_rate.row(2) = north.transpose();
    rows_by_force.row(2) = -vertical * north.transpose() * turn_up;
    c.value[row + 1] = vertical - earth_rate * std::sin(*latitude_);
    // Noise across north lengthens the horizontal part by var / (2 |w|) on average.
    c.value[row + 2] = across.norm() - east.dot(rate_noise * east) / (2 * across.norm()) - earth_rate * std::cos(*latitude_);
    std::fill_n(c.kind.begin() + row + 1, 2, Kind::gyro_rest);
  }
  add_derivatives(c, row, Triad::accel, rest, rows_by_force);
  add_derivatives(c, row, Triad::gyro, rest, rows_by_rate);
  c.blocks.push_back(
      {row,
       rows,
       rows_by_force * force_covariance(rest, spreads[0]) * rows_by_force.transpose() + rows_by_rate * rate_noise * rows_by_rate.transpose(),
       {}});
}

}  // namespace imulab::rests
