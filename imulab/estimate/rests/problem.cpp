#include "imulab/estimate/rests/problem.hpp"

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

/// What a coefficient is multiplied with.
double input_of(const Coefficient& c, const Vector3d& reading, const Vector3d& force) {
  if (c.term == Term::g_sensitivity) return force[c.column];
  if (c.term == Term::matrix) return reading[c.column];
  return c.term == Term::offset ? 1 : std::pow(reading[c.row], c.term == Term::quadratic ? 2 : 3);
}

}  // namespace

RestProblem::RestProblem(const kernel::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices)
    : rests_(start.rests),
      gravity_(site.gravity()),
      latitude_(site.latitude),
      scaling_(start.scaling),
      noise_{start.noise.accel.cwiseQuotient(scaling_.accel_scale), start.noise.gyro.cwiseQuotient(scaling_.gyro_scale)},
      model_(start.model),
      prior_(start.prior),
      sizes_(start.terms),
      indices_(std::move(indices)),
      roles_(indices_.size(), kernel::Role::estimated) {
  sizes_.accel.offset = 0.2 * gravity_, sizes_.gyro.offset = 1.0;
  for (kernel::TriadPrior* triad : {&sizes_.accel, &sizes_.gyro}) triad->scale = 0.2, triad->misalignment = 1e-2;
}

double RestProblem::prior_sigma(const Coefficient& c) const {
  kernel::PriorSizes sizes = sizes_;
  const auto row = (c.triad == Triad::accel ? prior_.accel : prior_.gyro).matrix.row(c.row);
  if (std::abs(row[c.row]) <= 0.9 * row.norm()) sizes.accel.misalignment = sizes.gyro.misalignment = 0.2;
  return kernel::prior_sigma(sizes, c, row.norm());
}

kernel::Parameters RestProblem::parameters(Index nuisances) const {
  kernel::Parameters out(static_cast<Index>(indices_.size()) + nuisances);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    out.role[i] = roles_[i];
    out.offset[static_cast<Index>(i)] = coefficient_value(prior_, indices_[i]) - coefficient_value(model_, indices_[i]);
    out.sigma[static_cast<Index>(i)] = prior_sigma(coefficient(indices_[i]));
  }
  return out;
}

std::vector<Index> RestProblem::not_determined(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const {
  constexpr double nothing = 0.9;  // of the prior sigma: the data say less than a quarter of what the prior says
  std::vector<Index> optional, least;
  double least_known = 0;
  for (std::size_t k = 0; k < indices_.size(); ++k) {
    if (parameters.role[k] != kernel::Role::estimated) continue;
    const auto i = static_cast<Index>(k);
    const Coefficient& c = coefficient(indices_[k]);
    const double prior = parameters.sigma[i], sigma = std::sqrt(covariance(i, i));
    if (is_optional(c.term)) {
      if (!(sigma <= nothing * prior)) optional.push_back(i);
    } else if (!(sigma < kernel::needed_sigma(c, prior)) && !(sigma / prior <= least_known)) {
      least = {i}, least_known = sigma / prior;
    }
  }
  return optional.empty() ? least : optional;
}

VectorXd RestProblem::longest_coefficient_step(Index size) const {
  VectorXd longest = VectorXd::Constant(size, kernel::no_prior);
  for (std::size_t i = 0; i < indices_.size(); ++i)
    if (const Coefficient& c = coefficient(indices_[i]); !is_optional(c.term)) longest[static_cast<Index>(i)] = prior_sigma(c);
  return longest;
}

void RestProblem::hold(const std::vector<Index>& undetermined) {
  for (const Index i : undetermined) roles_[static_cast<std::size_t>(i)] = kernel::Role::considered;
}

void RestProblem::correct_coefficients(const VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
}

Vector3d RestProblem::rate_at(const RestMeans& rest) const {
  return output(model_.gyro, scaling_.gyro(rest.gyro)) + model_.g_sensitivity * force_at(rest);
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
    c.jacobian.col(static_cast<Index>(i)).segment(row, by_output.rows()) += input_of(term, reading, force) * by_output.col(term.row);
  }
}

SuspectRows RestProblem::rest_suspect(const Conditions& conditions, std::size_t k) const {
  SuspectRows suspect{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}};
  const CovarianceBlock& block = conditions.blocks[k];
  for (Index row = block.first; row < block.first + block.size; ++row) suspect.rows.push_back(row);
  return suspect;
}

}  // namespace imulab::rests
