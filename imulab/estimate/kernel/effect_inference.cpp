// Infers effect sizes (size_inference.hpp) from a solution, and derives tests of the data and causes of a doubt.
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

SizedGroup::Of owner_of(const Coefficient& term, const ImuDeclaration& imu) {
  return is_declared(imu.term_sigmas, term) ? SizedGroup::Of::declared : SizedGroup::Of::rig;  // an IMU without effects may still have the term
}

double size_in(PriorSizes sizes, const Coefficient& c) {
  const double* const size = size_of(sizes, c);
  return size != nullptr ? *size : 0;
}

/// Removes the priors from values and their covariance, both in units of the prior sigmas. Along an eigenvector u of P with eigenvalue p, the
/// information of the data is V = 1/p - 1, and s = u.c / p.
ReducedEffects without_priors(const VectorXd& value, const MatrixXd& covariance) {
  if (value.size() == 0) return {};
  constexpr double nothing = 1e-10;  // rounding error of p
  const SymmetricEigen P = symmetric_eigen(covariance);
  const VectorXd along = P.vectors.transpose() * value;
  VectorXd V = VectorXd::Zero(value.size()), s = V;
  for (Index i = 0; i < value.size(); ++i)
    if (const double p = std::clamp(P.values[i], 1e-14, 1.0); 1 / p - 1 > nothing) V[i] = 1 / p - 1, s[i] = along[i] / p;
  return {P.vectors * V.asDiagonal() * P.vectors.transpose(), P.vectors * s};
}

/// Returns true if a and b imply the same values for columns of these sizes, to a few percent of a sigma, independently of priors if linear.
bool alike(const ReducedEffects& a, const ReducedEffects& b, const VectorXd& size) {
  constexpr double close = 0.02;
  if (a.eta.size() != b.eta.size()) return false;
  const VectorXd sigmas = size.cwiseProduct(b.L.diagonal().cwiseSqrt());  // sigmas of eta before the data
  const auto differs = [&](double difference, double scale) { return std::abs(difference) > close * (1 + scale); };
  for (Index i = 0; i < size.size(); ++i) {
    if (differs(size[i] * (a.eta[i] - b.eta[i]), std::abs(size[i] * b.eta[i]))) return false;
    for (Index k = 0; k <= i; ++k)
      if (differs(size[i] * size[k] * (a.L(i, k) - b.L(i, k)), sigmas[i] * sigmas[k])) return false;
  }
  return true;
}

/// Limits an inferred size. A value far beyond the expected size is not an effect, and the equations hold for small effects only. An effect that the
/// data do not resolve keeps at least half of its expected size or of the data's resolution, even if the IMU is better than its class.
double limited(double size, double expected, const SizedGroup& group, const ReducedEffects& data) {
  constexpr double most = 100, least = 0.5;
  if (group.of == SizedGroup::Of::declared) return size;
  const double information = data.L.diagonal().segment(group.first, group.size).mean();
  return std::clamp(size, least / std::sqrt(information + 1 / (expected * expected)), most * expected);
}

}  // namespace

Effects::Sized Effects::sized(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) const {
  Sized out{.hypotheses = hypotheses_};
  std::vector<Index> at;
  const auto add = [&](std::string name, const std::vector<Index>& members, SizedGroup::Of of, double size) {
    out.names.push_back(std::move(name));
    out.groups.push_back({std::ssize(at), std::ssize(members), of});
    at.insert(at.end(), members.begin(), members.end());
    out.in_use.push_back(size);
  };
  for (const EffectGroup& g : groups_) {
    std::vector<Index> members;
    for (Index k = 0; k < g.size; ++k) members.push_back(parameters.size() - size() + g.first + k);
    add(std::string(g.effect->name), members, g.of, g.sigma);
  }
  std::map<std::string, std::vector<Index>> by_term;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const Coefficient& c = coefficient(coefficients[k]);
    if (size_in(terms_, c) > 0 && parameters.role[k] == Role::estimated)
      by_term[fmt::format("{}.{}", to_string(c.triad), to_string(c.term))].push_back(static_cast<Index>(k));
  }
  for (const auto& [name, members] : by_term) {
    const Coefficient& c = coefficient(coefficients[static_cast<std::size_t>(members.front())]);
    add(name, members, owner_of(c, imu_), size_in(terms_, c));
    for (SizeHypothesis& h : out.hypotheses) h.sizes.push_back(size_in(terms_of(imu_, h.grade), c));
    out.terms.push_back(&c);
  }
  const VectorXd sigma = parameters.sigma(at), per_sigma = sigma.cwiseInverse();
  VectorXd per_size(std::ssize(at));  // for each column: a column of size 1 has the sigma of its parameter
  for (std::size_t k = 0; k < out.groups.size(); ++k) per_size.segment(out.groups[k].first, out.groups[k].size).setConstant(1 / out.in_use[k]);
  out.data = without_priors((solution.x - parameters.offset)(at).cwiseProduct(per_sigma),
                            per_sigma.asDiagonal() * solution.covariance(at, at) * per_sigma.asDiagonal());
  out.data.L = (per_size.asDiagonal() * out.data.L * per_size.asDiagonal()).eval();
  out.data.eta = out.data.eta.cwiseProduct(per_size).eval();
  return out;
}

VectorXd Effects::by_column(const Sized& of, const std::vector<double>& sizes) {
  VectorXd size(of.data.eta.size());
  for (std::size_t k = 0; k < sizes.size(); ++k) size.segment(of.groups[k].first, of.groups[k].size).setConstant(sizes[k]);
  return size;
}

bool Effects::infer(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) {
  if (hypotheses_.empty()) return false;
  const ReducedEffects before_this = std::exchange(sized_, sized(parameters, solution, coefficients)).data;
  if (sized_.groups.empty()) return false;
  if (posterior_ && alike(before_this, sized_.data, by_column(sized_, sized_.in_use))) return false;
  posterior_ = infer_sizes(sized_.data, sized_.groups, sized_.hypotheses);
  const std::vector<double>& weights = posterior_->weights;
  best_ = static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  std::vector<double> rms = posterior_->rms;
  for (std::size_t k = 0; k < rms.size(); ++k) rms[k] = limited(rms[k], sized_.hypotheses[best_].sizes[k], sized_.groups[k], sized_.data);
  double change = 0;
  for (std::size_t k = 0; k < rms.size(); ++k) change = std::max(change, std::abs(std::log(rms[k] / sized_.in_use[k])));
  for (std::size_t k = 0; k < groups_.size(); ++k) groups_[k].sigma = rms[k];
  for (std::size_t k = 0; k < sized_.terms.size(); ++k) *size_of(terms_, *sized_.terms[k]) = rms[groups_.size() + k];
  const VectorXd before = by_column(sized_, sized_.in_use);
  log_gain_ = posterior_->log_evidence - log_evidence(sized_.data, by_column(sized_, rms));
  log_gain_over_before_ = posterior_->log_evidence - log_evidence(sized_.data, before);
  cost_gain_ = explained_cost(sized_.data, by_column(sized_, posterior_->rms)) - explained_cost(sized_.data, before);
  sized_.in_use = rms;
  constexpr double settled = 0.05;  // uncertainties converge to a few percent
  return change > settled;
}

double Effects::log_gain_over_before(double cost) const { return log_gain_over_before_ - std::max(0.0, 0.5 * (cost_gain_ - cost)); }

double Effects::cost_of_limits(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) const {
  constexpr double most = 4;
  if (hypotheses_.empty()) return 0;
  const Sized now = sized(parameters, solution, coefficients);
  if (now.groups.empty()) return 0;
  std::vector<double> limited = now.hypotheses.at(best_).sizes;
  for (std::size_t k = 0; k < limited.size(); ++k) limited[k] = std::min(now.in_use[k], most * limited[k]);
  return explained_cost(now.data, by_column(now, now.in_use)) - explained_cost(now.data, by_column(now, limited));
}

double Effects::p_value(const Parameters& parameters, const Solution& solution, int rows, std::size_t dropped,
                        const std::vector<CoefficientIndex>& coefficients) const {
  // Each dropped row adds the cost of an event with a probability of 1 %.
  double cost = solution.chi2 + cost_of_limits(parameters, solution, coefficients) + 2 * std::log(100.0) * static_cast<double>(dropped);
  double degrees = rows;
  for (const Index i : parameters.with(Role::estimated)) {
    const auto k = static_cast<std::size_t>(i);
    const bool has_prior = std::isfinite(parameters.sigma[i]);
    if (has_prior) cost += std::pow((solution.x[i] - parameters.offset[i]) / parameters.sigma[i], 2);
    // The priors of offsets and matrices are so wide that they do not count: such a parameter takes as much of a degree of freedom as the data, and
    // not its prior, determine of it. Of few rows many parameters take less than one each.
    if (!has_prior)
      degrees -= 1;
    else if (k < coefficients.size() && !(size_in(terms_, coefficient(coefficients[k])) > 0))
      degrees -= 1 - std::min(1.0, solution.covariance(i, i) / std::pow(parameters.sigma[i], 2));
  }
  return chi_square_tail(cost, std::max(1.0, degrees));
}

MatrixXd Effects::constant_part(const Parameters& parameters, const MatrixXd& covariance, const std::vector<CoefficientIndex>& coefficients) const {
  if (hypotheses_.empty()) return {};
  std::vector<Index> constant;
  for (std::size_t k = 0; k < coefficients.size(); ++k)
    if (size_in(terms_, coefficient(coefficients[k])) > 0) constant.push_back(static_cast<Index>(k));
  for (const EffectGroup& g : groups_)
    for (Index k = 0; k < g.size && g.effect->constant(); ++k) constant.push_back(parameters.size() - size() + g.first + k);
  const MatrixXd by_prior =
      covariance(Eigen::all, constant).topRows(std::ssize(coefficients)) * parameters.sigma(constant).cwiseInverse().asDiagonal();
  return by_prior * by_prior.transpose();
}

std::string Effects::grade_of_factor(double factor) const {
  std::string_view nearest = grade();
  double least = std::abs(std::log(factor));
  for (const std::string_view name : graded_names()) {  // compares the mean ratio of the sizes that depend on the grade
    double sum = 0, n = 0;
    for (const EffectGroup& g : groups_)
      if (g.of != SizedGroup::Of::declared && g.of != SizedGroup::Of::rig)
        sum += std::log(effect_sigma(*g.effect, {}, name) / effect_sigma(*g.effect, {}, grade())), n += 1;
    if (const double distance = std::abs(sum / std::max(n, 1.0) - std::log(factor)); distance < least) least = distance, nearest = name;
  }
  return std::string(nearest);
}

std::vector<std::string> Effects::contradicting() const {
  constexpr double far = 4, sure = 0.99, apart = 2, likely = 0.9;  // `far` is relative to the expected size, `apart` to the other effects of the IMU
  const double told_apart = std::log(3);
  if (!posterior_) return {};
  const auto sizes = [&](std::size_t wider, double factor) {
    std::vector<double> of_groups = sized_.hypotheses[best_].sizes;
    of_groups[wider] *= factor;
    return by_column(sized_, of_groups);
  };
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < sized_.groups.size(); ++k)
    if (posterior_->exceeds(k, far) > sure && posterior_->stands_out(k, apart) > likely) found.push_back(k);
  if (found.empty()) return {};
  // Find other effects that explain the data as well while all but one have their expected sizes.
  std::vector<double> evidence(sized_.groups.size(), -HUGE_VAL);
  for (std::size_t k = 0; k < evidence.size(); ++k)
    for (double factor = far; factor < 1000; factor *= 2) evidence[k] = std::max(evidence[k], log_evidence(sized_.data, sizes(k, factor)));
  std::vector<std::string> out;
  for (const std::size_t k : found) out.push_back(sized_.names[k]);
  if (found.size() > 1) return out;
  for (std::size_t k = 0; k < evidence.size(); ++k)
    if (k != found.front() && evidence[k] > evidence[found.front()] - told_apart) out.push_back(sized_.names[k]);
  return out;
}

}  // namespace imulab::kernel
