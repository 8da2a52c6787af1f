#include "imulab/estimate/kernel/effects.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/grade.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Whose factors are in an effect's size.
SizedGroup::Of owner_of(const Effect& effect, const EffectSizes& sizes) {
  if (sizes.declared.contains(effect.name)) return SizedGroup::Of::declared;
  if ((effect.needs & (Effect::by_mount | Effect::by_centrifuge | Effect::by_latitude)) != 0) return SizedGroup::Of::rig;
  const bool accel = effect.changes(Triad::accel), gyro = effect.changes(Triad::gyro);
  return accel && gyro ? SizedGroup::Of::unit : accel ? SizedGroup::Of::accel : SizedGroup::Of::gyro;
}

SizedGroup::Of owner_of(const Coefficient& term, const ImuDeclaration& imu) {
  return is_declared(imu.term_sigmas, term) ? SizedGroup::Of::declared : SizedGroup::Of::rig;  // an IMU without effects may have it all the same
}

double size_in(PriorSizes sizes, const Coefficient& c) {
  const double* const size = size_of(sizes, c);
  return size != nullptr ? *size : 0;
}

PriorSizes terms_of(ImuDeclaration imu, const std::string& grade_name) {
  imu.grade = grade_name;
  return optional_priors(imu);
}

/// From values with their covariance under these sigmas, in units of the sigmas: along the eigenvectors u of P with eigenvalues p the data alone say
/// V = 1/p - 1 and s = u.c / p.
ReducedEffects without_priors(const VectorXd& value, const MatrixXd& covariance) {
  if (value.size() == 0) return {};
  constexpr double nothing = 1e-10;  // rounding of p
  const SymmetricEigen P = symmetric_eigen(covariance);
  const VectorXd along = P.vectors.transpose() * value;
  VectorXd V = VectorXd::Zero(value.size()), s = V;
  for (Index i = 0; i < value.size(); ++i)
    if (const double p = std::clamp(P.values[i], 1e-14, 1.0); 1 / p - 1 > nothing) V[i] = 1 / p - 1, s[i] = along[i] / p;
  return {P.vectors * V.asDiagonal() * P.vectors.transpose(), P.vectors * s};
}

/// Do they say the same of columns of these sizes, to some percent of a sigma? So they do under other priors where the equations are linear.
bool alike(const ReducedEffects& a, const ReducedEffects& b, const VectorXd& size) {
  constexpr double close = 0.02;
  if (a.eta.size() != b.eta.size()) return false;
  const VectorXd sigmas = size.cwiseProduct(b.L.diagonal().cwiseSqrt());  // before the data, of what they say
  const auto differs = [&](double difference, double scale) { return std::abs(difference) > close * (1 + scale); };
  for (Index i = 0; i < size.size(); ++i) {
    if (differs(size[i] * (a.eta[i] - b.eta[i]), std::abs(size[i] * b.eta[i]))) return false;
    for (Index k = 0; k <= i; ++k)
      if (differs(size[i] * size[k] * (a.L(i, k) - b.L(i, k)), sigmas[i] * sigmas[k])) return false;
  }
  return true;
}

}  // namespace

double EffectSizes::of(const Effect& effect) const { return effect_sigma(effect, declared, likeliest(grades).name); }

EffectSizes effect_sizes(const Session& session, const SeenOfUnit& seen) {
  EffectSizes sizes{session.imu.effect_sigmas, likely_grades(session.imu, seen), session.imu};
  const auto declare = [&](const char* name, double sigma) {
    if (sigma > 0) sizes.declared.try_emplace(name, sigma);
  };
  const NoiseModels noise = declared_terms(session.imu);
  if (!noise.accel.turn_on.fixed) declare("accel.turn_on", noise.accel.turn_on.value);
  if (!noise.gyro.turn_on.fixed) declare("gyro.turn_on", noise.gyro.turn_on.value);
  if (session.site.latitude_sigma) sizes.declared.try_emplace("site.latitude", *session.site.latitude_sigma);  // 0: exactly known
  return sizes;
}

Effects::Effects(const EffectSizes& sizes, const EffectSetting& setting) : imu_(sizes.imu), terms_(terms_of(imu_, likeliest(sizes.grades).name)) {
  for (const LikelyGrade& g : sizes.grades) hypotheses_.push_back({g.name, g.log_weight});
  for (const Effect& effect : imulab::effects()) {
    const int columns = effect.columns(setting);
    const double sigma = sizes.of(effect);
    if (columns == 0 || !(sigma > 0)) continue;
    groups_.push_back({{size(), columns, owner_of(effect, sizes)}, &effect, sigma});
    for (SizeHypothesis& h : hypotheses_) h.sizes.push_back(effect_sigma(effect, sizes.declared, h.grade));
    for (int k = 0; k < columns; ++k) columns_.push_back({&effect, k});
  }
  value_ = VectorXd::Zero(size());
}

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
  VectorXd per_size(std::ssize(at));  // of the group, by column: a column of size 1 has the sigma of its parameter
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

double Effects::infer(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) {
  if (hypotheses_.empty()) return 0;
  const ReducedEffects before_this = std::exchange(sized_, sized(parameters, solution, coefficients)).data;
  if (sized_.groups.empty()) return 0;
  if (posterior_ && alike(before_this, sized_.data, by_column(sized_, sized_.in_use))) return 0;
  posterior_ = infer_sizes(sized_.data, sized_.groups, sized_.hypotheses);
  const std::vector<double>& weights = posterior_->weights;
  best_ = static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  // What is far beyond that is no effect; and the equations hold for small ones.
  constexpr double most = 100;
  std::vector<double> rms = posterior_->rms;
  for (std::size_t k = 0; k < rms.size(); ++k) {
    const SizedGroup& g = sized_.groups[k];
    const double expected = sized_.hypotheses[best_].sizes[k];
    rms[k] = std::min(rms[k], most * expected);
    if (g.of == SizedGroup::Of::declared) continue;
    // That an IMU is better than its class says little of an effect that the data would not show: no size is below half of what is expected of it, or
    // of what the data resolve.
    constexpr double least = 0.5;
    const double information = sized_.data.L.diagonal().segment(g.first, g.size).mean();
    rms[k] = std::max(rms[k], least / std::sqrt(information + 1 / (expected * expected)));
  }
  double change = 0;
  for (std::size_t k = 0; k < rms.size(); ++k) change = std::max(change, std::abs(std::log(rms[k] / sized_.in_use[k])));
  for (std::size_t k = 0; k < groups_.size(); ++k) groups_[k].sigma = rms[k];
  for (std::size_t k = 0; k < sized_.terms.size(); ++k) *size_of(terms_, *sized_.terms[k]) = rms[groups_.size() + k];
  const VectorXd before = by_column(sized_, sized_.in_use);
  log_gain_ = posterior_->log_evidence - log_evidence(sized_.data, by_column(sized_, rms));
  log_gain_over_before_ = posterior_->log_evidence - log_evidence(sized_.data, before);
  cost_gain_ = explained_cost(sized_.data, by_column(sized_, posterior_->rms)) - explained_cost(sized_.data, before);
  sized_.in_use = rms;
  return change;
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
  // What chance does once in a hundred.
  double cost = solution.chi2 + cost_of_limits(parameters, solution, coefficients) + 2 * std::log(100.0) * static_cast<double>(dropped);
  double degrees = rows;
  for (const Index i : parameters.with(Role::estimated)) {
    const auto k = static_cast<std::size_t>(i);
    const bool has_prior = std::isfinite(parameters.sigma[i]);
    if (has_prior) cost += std::pow((solution.x[i] - parameters.offset[i]) / parameters.sigma[i], 2);
    // The priors of offsets and matrices are as good as none.
    if (!has_prior || (k < coefficients.size() && !(size_in(terms_, coefficient(coefficients[k])) > 0))) degrees -= 1;
  }
  return chi_square_tail(cost, std::max(1.0, degrees));
}

std::string Effects::grade_of_factor(double factor) const {
  std::string_view nearest = grade();
  double least = std::abs(std::log(factor));
  for (const std::string_view name : graded_names()) {  // by the mean ratio of the sizes that a grade sets
    double sum = 0, n = 0;
    for (const EffectGroup& g : groups_)
      if (g.of != SizedGroup::Of::declared && g.of != SizedGroup::Of::rig)
        sum += std::log(effect_sigma(*g.effect, {}, name) / effect_sigma(*g.effect, {}, grade())), n += 1;
    if (const double distance = std::abs(sum / std::max(n, 1.0) - std::log(factor)); distance < least) least = distance, nearest = name;
  }
  return std::string(nearest);
}

std::vector<std::string> Effects::contradicting() const {
  constexpr double far = 4, sure = 0.99, apart = 2, likely = 0.9;  // times the expected size; apart: from the other effects of the IMU
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
  // Which others explain the data as well, if all but one have the expected sizes.
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

void Effects::add_to(Parameters& parameters) const {
  const Index first = parameters.size() - size();
  parameters.offset.tail(size()) = -value_;
  for (const EffectGroup& g : groups_) parameters.sigma.segment(first + g.first, g.size).setConstant(g.sigma);
}

VectorXd Effects::sigma() const {
  VectorXd out(size());
  for (const EffectGroup& g : groups_) out.segment(g.first, g.size).setConstant(g.sigma);
  return out;
}

double Effects::degrees_of_freedom(const MatrixXd& covariance) const {
  return (1 - covariance.diagonal().tail(size()).array() / sigma().array().square()).sum();
}

OutputChange Effects::output(const EffectState& state) const {
  OutputChange sum;
  for (Index k = 0; k < size(); ++k) {
    if (value_[k] == 0) continue;
    const OutputChange change = columns_[static_cast<std::size_t>(k)].at(state);
    sum.force += value_[k] * change.force;
    sum.rate += value_[k] * change.rate;
  }
  return sum;
}

void Effects::add_derivatives(MatrixXd& jacobian, Index row, Triad triad, const MatrixXd& by_output, const EffectState& state) const {
  const Index first = jacobian.cols() - size();
  for (Index k = 0; k < size(); ++k) {
    const EffectColumn& c = columns_[static_cast<std::size_t>(k)];
    if (!c.effect->changes(triad)) continue;
    const OutputChange change = c.at(state);
    jacobian.col(first + k).segment(row, by_output.rows()) -= by_output * (triad == Triad::accel ? change.force : change.rate);
  }
}

namespace {

EffectTest tested(const EffectGroup& group, const VectorXd& value, const MatrixXd& covariance) {
  EffectTest out{.effect = group.effect, .value = value, .sigma = covariance.diagonal().cwiseSqrt()};
  // In units of the prior, along the eigenvectors u of P with eigenvalues p: V = 1/p - 1, s = u.c / p.
  const SymmetricEigen P = symmetric_eigen(covariance / (group.sigma * group.sigma));
  const VectorXd along = P.vectors.transpose() * value / group.sigma;
  constexpr double seen = 1e-3, hardly = 1e-6;  // of the prior's information
  constexpr double obvious = 30;                // chi-square of one: five and a half sigma, of a prior that is far too narrow
  for (Index i = 0; i < along.size(); ++i) {
    const double p = std::clamp(P.values[i], 1e-12, 1.0), V = 1 / p - 1, s = along[i] / p;
    if (!(V > seen) && !(V > hardly && s * s / V > obvious)) continue;
    out.rank += 1;
    out.statistic += s * s / V;
    out.log_evidence += 0.5 * (s * s / (V + 1) - std::log1p(V));
  }
  if (out.rank > 0) out.p_value = chi_square_tail(out.statistic, out.rank);
  return out;
}

}  // namespace

std::vector<EffectTest> test_effects(const Effects& effects, const MatrixXd& covariance) {
  std::vector<EffectTest> tests;
  for (const EffectGroup& g : effects.groups()) {
    const Index at = covariance.rows() - effects.size() + g.first, n = g.size;
    tests.push_back(tested(g, effects.value().segment(g.first, n), covariance.block(at, at, n, n)));
  }
  return tests;
}

namespace {

double significance_of(const EffectTest& test, const std::vector<EffectTest>& all) {
  const auto seen = std::count_if(all.begin(), all.end(), [](const EffectTest& t) { return t.rank > 0; });
  return test.rank > 0 ? test.p_value * static_cast<double>(seen) : 1;
}

}  // namespace

namespace {

/// Notes the effects that could be ten times as large as expected and neither show nor be covered: along the change of an effect by which a
/// coefficient follows it most, the data tell less than a tenth of what the prior does, and ten sigmas of the prior shift the coefficient by more
/// than three of its own. One that the data show to be larger elsewhere cannot be assumed: that is a doubt.
void name_assumed(Calibration& calibration, Findings& findings, const Effects& effects, const MatrixXd& covariance,
                  const std::vector<CoefficientIndex>& coefficients) {
  constexpr double told = 0.1, follows = 0.3;
  const auto is_among = [](const std::vector<std::string>& names, std::string_view name) { return std::ranges::find(names, name) != names.end(); };
  std::vector<std::string>& considered = calibration.quality.considered;
  const Index first = covariance.rows() - effects.size();
  for (const EffectGroup& g : effects.groups()) {
    const MatrixXd P = covariance.block(first + g.first, first + g.first, g.size, g.size) / (g.sigma * g.sigma);
    std::vector<std::string_view> following;
    for (std::size_t k = 0; k < coefficients.size(); ++k) {
      const auto row = static_cast<Index>(k);
      const VectorXd shift = covariance.block(row, first + g.first, 1, g.size).transpose() / g.sigma, along = shift.normalized();
      const bool is_stated = contains(calibration.estimated, coefficients[k]) && !is_among(considered, coefficient(coefficients[k]).name);
      if (is_stated && shift.norm() > follows * std::sqrt(covariance(row, row)) && along.dot(along - P * along) < told)
        following.push_back(coefficient(coefficients[k]).name);
    }
    if (following.empty()) continue;
    if (!is_among(considered, g.effect->name)) considered.emplace_back(g.effect->name);
    findings.note(
        fmt::format("assumed: {} of {:.3g} {} (one sigma); the data hardly show it, and if it is larger, so are the errors of {}; to see it: {}",
                    g.effect->name, g.sigma / g.effect->unit, g.effect->unit_name, fmt::join(following, ", "), g.effect->advice));
  }
}

/// States how large the IMU's effects are against those of its class; the grade that fits is told where that is not the declared one.
void judge_unit_size(Quality& quality, Findings& findings, const Effects& effects) {
  constexpr double worse = 4, better = 0.1, much_worse = 10, sure = 0.99;
  const SizePosterior& found = *effects.posterior();
  UnitSize size{.factor = std::exp(found.log_factor), .factor_sigma = found.sigma, .grade = effects.grade()};
  if (found.weights.size() > 1) {
    for (std::size_t k = 0; k < found.weights.size(); ++k) size.weights[effects.grade(k)] = found.weights[k];
    findings.note(
        fmt::format("no grade declared: the noise, the offsets and the effects are most probably those of grade {} ({:.0f} %); sizes are "
                    "averaged over the grades",
                    size.grade, 100 * size.weights[size.grade]));
  } else if (found.factor_exceeds(worse) > sure || found.factor_exceeds(better) < 1 - sure) {
    std::string words = fmt::format("the IMU's effects are {:.2g} times those of its grade, {}", size.factor, size.grade);
    if (const std::string other = effects.grade_of_factor(size.factor); other != size.grade) words += "; the grade that fits is " + other;
    if (found.factor_exceeds(much_worse) > sure)
      findings.doubt(words);
    else if (size.factor > 1)
      findings.warn(words);
    else
      findings.note(words);
  }
  quality.unit_size = std::move(size);
}

}  // namespace

namespace {

/// The offsets of n recorded switch-ons that differ by one sigma s are those of the IMU, or of its next switch-on, to s / sqrt(n) or s sqrt(1 + 1/n).
void state_turn_on(Calibration& calibration, const Effects& effects) {
  for (const EffectGroup& g : effects.groups()) {
    const bool accel = g.effect->name == "accel.turn_on";
    if (!accel && g.effect->name != "gyro.turn_on") continue;
    const double n = 1 + static_cast<double>(g.size) / 3;
    if (!calibration.turn_on) calibration.turn_on.emplace();
    (accel ? calibration.turn_on->accel : calibration.turn_on->gyro) = g.sigma / std::sqrt(n);
    for (const CoefficientIndex index : calibration.estimated)
      if (const Coefficient& c = coefficient(index); c.term == Term::offset && c.triad == (accel ? Triad::accel : Triad::gyro))
        calibration.next_switch_on[std::string(c.name)] = std::hypot(*standard_uncertainty(calibration, index), g.sigma * std::sqrt(1 + 1 / n));
  }
}

}  // namespace

void add_effects(Calibration& calibration, Findings& findings, const Effects& effects, const MatrixXd& covariance, double level,
                 const std::vector<CoefficientIndex>& coefficients) {
  const std::vector<EffectTest> tests = test_effects(effects, covariance);
  Quality& quality = calibration.quality;
  for (const EffectTest& t : tests) {
    EffectEstimate out{std::string(t.effect->name), std::string(t.effect->unit_name), {}, {}, significance_of(t, tests) < level};
    for (Index k = 0; k < t.value.size(); ++k) out.values.push_back(t.value[k] / t.effect->unit), out.sigma.push_back(t.sigma[k] / t.effect->unit);
    quality.effects.push_back(std::move(out));
    if (t.rank == 0) quality.considered.emplace_back(t.effect->name);
  }
  state_turn_on(calibration, effects);
  name_assumed(calibration, findings, effects, covariance, coefficients);
  if (effects.posterior()) judge_unit_size(quality, findings, effects);
  doubt_causes(quality, findings, effects.contradicting());
}

void doubt_improbable(Findings& findings, const Effects& effects, double p_value) {
  constexpr double level = 1e-3;
  if (p_value < level)
    findings.doubt(
        fmt::format("noise and an IMU of grade {} explain the data with a probability of {:.1g}: something is wrong that is no known effect",
                    effects.grade(), p_value));
}

void doubt_causes(Quality& quality, Findings& findings, const std::vector<std::string>& causes) {
  if (causes.empty()) return;
  std::vector<std::string> words, advice;  // several effects may have one of them
  const auto add = [](std::vector<std::string>& to, std::string text) {
    if (std::ranges::find(to, text) == to.end()) to.push_back(std::move(text));
  };
  for (const std::string& name : causes) {
    const Effect* const effect = find_effect(name);
    add(words, effect != nullptr ? std::string(effect->words) : name + " is larger");
    if (effect != nullptr) add(advice, std::string(effect->advice));
  }
  quality.cause = fmt::format("{}", fmt::join(causes, ", "));
  findings.doubt(fmt::format("{}, by more than is expected of this IMU", fmt::join(words, ", or ")));
  if (causes.size() > 1 && !advice.empty())
    findings.warn(fmt::format("the data do not tell these apart: {}; to do so: {}", *quality.cause, fmt::join(advice, ", or ")));
}

}  // namespace imulab::kernel
