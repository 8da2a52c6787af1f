#include "imulab/estimate/kernel/effect_findings.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The test of one effect on the data alone, without its prior.
struct EffectTest {
  const Effect* effect = nullptr;
  int rank = 0;          ///< number of observable combinations of its columns
  double statistic = 0;  ///< chi-square with `rank` degrees of freedom if the effect is absent
  double p_value = 1;
  VectorXd value, sigma;  ///< one element per column, including the prior
};

/// Computes the test from the joint fit. With P_kk the covariance of effect k and S_k its prior, V_k = P_kk^-1 - S_k^-1 and s_k = P_kk^-1 c_k.
EffectTest tested(const EffectGroup& group, const VectorXd& value, const MatrixXd& covariance) {
  EffectTest out{.effect = group.effect, .value = value, .sigma = covariance.diagonal().cwiseSqrt()};
  // In units of the prior, along the eigenvectors u of P with eigenvalues p: V = 1/p - 1, s = u.c / p.
  const SymmetricEigen P = symmetric_eigen(covariance / (group.sigma * group.sigma));
  const VectorXd along = P.vectors.transpose() * value / group.sigma;
  constexpr double seen = 1e-3, hardly = 1e-6;  // relative to the information of the prior
  constexpr double obvious = 30;                // chi-square of one degree of freedom: 5.5 sigma, with a prior that is far too narrow
  for (Index i = 0; i < along.size(); ++i) {
    const double p = std::clamp(P.values[i], 1e-12, 1.0), V = 1 / p - 1, s = along[i] / p;
    if (!(V > seen) && !(V > hardly && s * s / V > obvious)) continue;
    out.rank += 1;
    out.statistic += s * s / V;
  }
  if (out.rank > 0) out.p_value = chi_square_tail(out.statistic, out.rank);
  return out;
}

/// Tests every effect once.
std::vector<EffectTest> test_effects(const Effects& effects, const MatrixXd& covariance) {
  std::vector<EffectTest> tests;
  for (const EffectGroup& g : effects.groups()) {
    const Index at = covariance.rows() - effects.size() + g.first, n = g.size;
    tests.push_back(tested(g, effects.value().segment(g.first, n), covariance.block(at, at, n, n)));
  }
  return tests;
}

double significance_of(const EffectTest& test, const std::vector<EffectTest>& all) {
  const auto seen = std::count_if(all.begin(), all.end(), [](const EffectTest& t) { return t.rank > 0; });
  return test.rank > 0 ? test.p_value * static_cast<double>(seen) : 1;
}

/// Names effects as assumed if they could be ten times as large as expected without being observed or covered. In the direction of the effect that
/// moves a coefficient most, the data supply less than a fifth of the information, and ten prior sigmas shift the coefficient by more than three of
/// its own sigmas. With at least a fifth, ten sigmas are known to two, hence certainly exceed the four sigmas of a doubt.
void name_assumed(Calibration& calibration, Findings& findings, const Effects& effects, const MatrixXd& covariance,
                  const std::vector<CoefficientIndex>& coefficients) {
  constexpr double told = 0.2, follows = 0.3;
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
    findings.add<Code::effect_assumed>(Subject{g.effect->name}, g.sigma / g.effect->unit, g.effect->unit_name,
                                       fmt::format("{}", fmt::join(following, ", ")), g.effect->advice);
  }
}

/// States the size of the IMU's effects relative to its class, and the grade that fits if it is not the declared one.
void judge_unit_size(Quality& quality, Findings& findings, const Effects& effects) {
  constexpr double worse = 4, better = 0.1, much_worse = 10, sure = 0.99;
  const SizePosterior& found = *effects.posterior();
  UnitSize size{.factor = std::exp(found.log_factor), .factor_sigma = found.sigma, .grade = effects.grade()};
  if (found.weights.size() > 1) {
    for (std::size_t k = 0; k < found.weights.size(); ++k) size.weights[effects.grade(k)] = found.weights[k];
    if (const std::optional<std::string>& declared = effects.declared_grade())
      findings.add<Code::grade_contradicted>(*declared, size.grade, 100 * size.weights[size.grade]);
    else
      findings.add<Code::likely_grade>(size.grade, 100 * size.weights[size.grade]);
  } else if (found.factor_exceeds(worse) > sure || found.factor_exceeds(better) < 1 - sure) {
    const std::string other = effects.grade_of_factor(size.factor);
    findings.add<Code::unit_size>(size.factor, size.grade, other != size.grade ? "; the grade that fits is " + other : "").severity =
        found.factor_exceeds(much_worse) > sure ? Severity::doubt
        : size.factor > 1                       ? Severity::warning
                                                : Severity::note;
  }
  quality.unit_size = std::move(size);
}

/// The mean offset of n recorded switch-ons with standard deviation s represents the IMU to s / sqrt(n), and its next switch-on to s sqrt(1 + 1/n).
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

/// Doubts a result because of these effects or terms.
void doubt_causes(Quality& quality, Findings& findings, const std::vector<std::string>& causes) {
  if (causes.empty()) return;
  std::vector<std::string> words, advice;  // several effects can have the same text
  const auto add = [](std::vector<std::string>& to, std::string text) {
    if (std::ranges::find(to, text) == to.end()) to.push_back(std::move(text));
  };
  for (const std::string& name : causes) {
    const Effect* const effect = find_effect(name);
    add(words, effect != nullptr ? std::string(effect->words) : name + " is larger");
    if (effect != nullptr) add(advice, std::string(effect->advice));
  }
  quality.cause = fmt::format("{}", fmt::join(causes, ", "));
  const Effect* const first = find_effect(causes.front());
  const bool of_site = first != nullptr && (first->needs & Effect::by_latitude) != 0;
  Finding& doubt = findings.add<Code::unexpected_effect>(fmt::format("{}", fmt::join(words, ", or ")));
  doubt.subject = *quality.cause;
  if (of_site) doubt.code = Code::unexpected_site_effect;
  if (causes.size() > 1 && !advice.empty())
    findings.add<Code::effects_not_told_apart>(Subject{*quality.cause}, fmt::format("{}", fmt::join(advice, ", or ")));
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
  if (p_value < level) findings.add<Code::improbable_data>(effects.grade(), p_value);
}

}  // namespace imulab::kernel
