#include "imulab/estimate/rests/problem.hpp"

#include "imulab/estimate/kernel/prior.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

Matrix3d mean_covariance(const TriadModel& model, const Vector3d& sample_sigma, std::size_t samples, double spread) {
  return Matrix3d(model.matrix * sample_sigma.cwiseAbs2().asDiagonal() * model.matrix.transpose()) / static_cast<double>(samples) +
         spread * spread * Matrix3d::Identity();
}

}  // namespace

double prior_sigma(const SensorModel& prior, const Coefficient& c, double gravity) {
  kernel::PriorSizes sizes{{0.2 * gravity, 0.2, 1e-2}, {1.0, 0.2, 1e-2}};
  const auto row = (c.triad == Triad::accel ? prior.accel : prior.gyro).matrix.row(c.row);
  if (std::abs(row[c.row]) <= 0.9 * row.norm()) sizes.accel.misalignment = sizes.gyro.misalignment = 0.2;
  return kernel::prior_sigma(sizes, c, row.norm());
}

RestProblem::RestProblem(const kernel::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices)
    : rests_(start.rests),
      gravity_(site.gravity()),
      latitude_(site.latitude),
      scaling_(start.scaling),
      noise_{start.noise.accel.cwiseQuotient(scaling_.accel_scale), start.noise.gyro.cwiseQuotient(scaling_.gyro_scale)},
      model_(start.model),
      prior_(start.prior),
      indices_(std::move(indices)),
      roles_(indices_.size(), kernel::Role::estimated) {}

kernel::Parameters RestProblem::parameters(Index nuisances) const {
  kernel::Parameters out(static_cast<Index>(indices_.size()) + nuisances);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    out.role[i] = roles_[i];
    out.offset[static_cast<Index>(i)] = coefficient_value(prior_, indices_[i]) - coefficient_value(model_, indices_[i]);
    out.sigma[static_cast<Index>(i)] = prior_sigma(prior_, coefficient(indices_[i]), gravity_);
  }
  return out;
}

VectorXd RestProblem::needed_sigma() const {
  VectorXd needed = parameters(0).sigma;
  for (std::size_t i = 0; i < indices_.size(); ++i)
    needed[static_cast<Index>(i)] = kernel::needed_sigma(coefficient(indices_[i]), needed[static_cast<Index>(i)]);
  return needed;
}

void RestProblem::hold(const std::vector<Index>& undetermined) {
  for (const Index i : undetermined) roles_[static_cast<std::size_t>(i)] = kernel::Role::considered;
}

void RestProblem::correct_coefficients(const VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
}

Vector3d RestProblem::rate_at(const RestMeans& rest) const {
  return linear_output(model_.gyro, scaling_.gyro(rest.gyro)) + model_.g_sensitivity * force_at(rest);
}

Matrix3d RestProblem::force_covariance(const RestMeans& rest, double spread) const {
  return mean_covariance(model_.accel, noise_.accel, rest.range.size(), spread);
}

Matrix3d RestProblem::rate_covariance(const RestMeans& rest, double spread) const {
  return mean_covariance(model_.gyro, noise_.gyro, rest.range.size(), spread);
}

void RestProblem::add_derivatives(Conditions& c, Index row, Triad triad, const RestMeans& rest, const Eigen::MatrixXd& by_output) const {
  const Vector3d reading = triad == Triad::accel ? scaling_.accel(rest.accel) : scaling_.gyro(rest.gyro), force = force_at(rest);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != triad) continue;
    const double input = term.term == Term::offset ? 1.0 : term.term == Term::matrix ? reading[term.column] : force[term.column];
    c.jacobian.col(static_cast<Index>(i)).segment(row, by_output.rows()) += input * by_output.col(term.row);
  }
}

SuspectRows RestProblem::rest_suspect(const Conditions& conditions, std::size_t k) const {
  SuspectRows suspect{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}};
  const CovarianceBlock& block = conditions.blocks[k];
  for (Index row = block.first; row < block.first + block.size; ++row) suspect.rows.push_back(row);
  return suspect;
}

}  // namespace imulab::rests
