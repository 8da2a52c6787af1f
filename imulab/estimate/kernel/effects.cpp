#include "imulab/estimate/kernel/effects.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

EffectSizes effect_sizes(const Session& session, const Vector3d& accel_offset) {
  const bool small = accel_offset.cwiseAbs().maxCoeff() < 0.2 * session.site.gravity();
  EffectSizes sizes{session.imu.effect_sigmas, session.imu.grade.value_or(""), small ? accel_offset.norm() / std::sqrt(3.0) : 0.03 * unit::g};
  const auto declare = [&](const char* name, double sigma) {
    if (sigma > 0) sizes.declared.try_emplace(name, sigma);
  };
  const NoiseModels noise = declared_terms(session.imu);
  if (!noise.accel.turn_on.fixed) declare("accel.turn_on", noise.accel.turn_on.value);
  if (!noise.gyro.turn_on.fixed) declare("gyro.turn_on", noise.gyro.turn_on.value);
  if (session.site.latitude_sigma) sizes.declared.try_emplace("site.latitude", *session.site.latitude_sigma);  // 0: exactly known
  return sizes;
}

Effects::Effects(const EffectSizes& sizes, const EffectSetting& setting) {
  for (const Effect& effect : imulab::effects()) {
    const int columns = effect.columns(setting);
    const double sigma = effect_sigma(effect, sizes.declared, sizes.grade, sizes.accel_offset);
    if (columns == 0 || !(sigma > 0)) continue;
    groups_.push_back({&effect, size(), columns, sigma});
    for (int k = 0; k < columns; ++k) columns_.push_back({&effect, k});
  }
  value_ = VectorXd::Zero(size());
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

/// Of data and priors at a solution.
double cost_of(const Solution& solution, const Parameters& parameters) {
  double sum = solution.chi2;
  for (const Index i : parameters.with(Role::estimated))
    if (std::isfinite(parameters.sigma[i])) sum += std::pow((solution.x[i] - parameters.offset[i]) / parameters.sigma[i], 2);
  return sum;
}

}  // namespace

std::optional<Contradicted> contradicted_prior(const Information& data, const Parameters& parameters, const std::vector<PriorGroup>& groups) {
  constexpr double level = 1e-3, told_apart = 3;  // the latter of the logarithms of two probabilities
  const Solution before = solve(data, parameters);
  const VectorXd value = before.x - parameters.offset;
  std::vector<double> evidence(groups.size(), -HUGE_VAL), factor(groups.size(), 1);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const std::vector<Index>& at = groups[k].at;
    const VectorXd of_group = value(at), prior = parameters.sigma(at);
    const MatrixXd covariance = before.covariance(at, at);
    factor[k] = widening(of_group, prior, covariance);
    if (factor[k] > 1) evidence[k] = evidence_of_wider(of_group, prior, covariance, factor[k]);
  }
  const auto best = std::max_element(evidence.begin(), evidence.end()) - evidence.begin();
  if (groups.empty() || !std::isfinite(evidence[static_cast<std::size_t>(best)])) return std::nullopt;
  const auto found = static_cast<std::size_t>(best);
  Contradicted out{found, factor[found], evidence[found], {groups[found].name}};
  Parameters wider = parameters;
  for (const Index i : groups[out.group].at) wider.sigma[i] *= out.factor;
  const Solution after = solve(data, wider);
  const double degrees = std::max(1.0, after.degrees_of_freedom), scale = std::max(1.0, after.chi2 / degrees);
  const Deviation explained{(cost_of(before, parameters) - cost_of(after, wider)) / scale, static_cast<int>(groups[out.group].at.size())};
  if (explained.log_probability(degrees) > std::log(level / static_cast<double>(groups.size()))) return std::nullopt;
  for (std::size_t k = 0; k < groups.size(); ++k)
    if (k != out.group && evidence[k] > evidence[out.group] - told_apart) out.alike.push_back(groups[k].name);
  return out;
}

std::vector<PriorGroup> Effects::prior_groups(Index parameters) const {
  std::vector<PriorGroup> out;
  for (const EffectGroup& g : groups_) {
    PriorGroup& group = out.emplace_back(PriorGroup{std::string(g.effect->name), {}});
    for (Index k = 0; k < g.size; ++k) group.at.push_back(parameters - size() + g.first + k);
  }
  return out;
}

bool Effects::widen(const Information& data, const Parameters& parameters, double for_another) {
  const std::optional<Contradicted> found = contradicted_prior(data, parameters, prior_groups(parameters.size()));
  if ((found ? found->evidence : 0) < for_another) return false;
  if (!found) return widen_if_likelier(data, parameters);
  add_causes(found->alike);
  const double factor = std::min(found->factor, most_widening / groups_[found->group].widened);
  widen({found->group, std::max(1.0, factor), 0});
  return factor > 1 || widen_if_likelier(data, parameters);
}

namespace {

/// Logarithm of the ratio of probabilities: as much in few of a hundred sessions, where the prior is right.
constexpr double more_likely = 2;

}  // namespace

bool Effects::widen_if_likelier(const Information& data, const Parameters& parameters, double for_another) {
  const Solution before = solve(data, parameters);
  const VectorXd value = (before.x - parameters.offset).tail(size());
  const std::optional<Wider> found = likelier(value, before.covariance);
  if (!found || found->evidence < for_another) return false;
  // Noise of another size than stated explains, too: for it speaks as much before, and as much after.
  Effects wider = *this;
  wider.widen(*found);
  Parameters after = parameters;
  wider.add_to(after);
  const auto for_noise = [](const Solution& s) { return Deviation{s.chi2, static_cast<int>(s.degrees_of_freedom)}.evidence(); };
  if (found->evidence + for_noise(solve(data, after)) - for_noise(before) < more_likely) return false;
  *this = std::move(wider);
  return true;
}

std::optional<Effects::Wider> Effects::likelier(const VectorXd& value, const MatrixXd& covariance) const {
  std::optional<Wider> best;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const EffectGroup& g = groups_[k];
    if (g.widened > 1) continue;
    const Index at = covariance.rows() - size() + g.first;
    const double evidence = evidence_of_wider(value.segment(g.first, g.size), VectorXd::Constant(g.size, g.sigma),
                                              covariance.block(at, at, g.size, g.size), most_widening);
    if (evidence > (best ? best->evidence : more_likely)) best = Wider{k, most_widening, evidence};
  }
  return best;
}

void Effects::add_causes(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (std::find(causes_.begin(), causes_.end(), name) == causes_.end()) causes_.push_back(name);
}

std::vector<Effects::Wider> Effects::contradicted(const MatrixXd& covariance) const {
  std::vector<Wider> found;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const EffectGroup& g = groups_[k];
    const Index at = covariance.rows() - size() + g.first;
    const VectorXd value = value_.segment(g.first, g.size), prior = VectorXd::Constant(g.size, g.sigma);
    const MatrixXd P = covariance.block(at, at, g.size, g.size);
    if (const double wanted = widening(value, prior, P); wanted > 1)
      found.push_back({k, std::min(wanted, most_widening / g.widened), evidence_of_wider(value, prior, P, wanted)});
  }
  std::sort(found.begin(), found.end(), [](const Wider& a, const Wider& b) { return a.evidence > b.evidence; });
  return found;
}

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
    if (!(g.widened > 1) || !effects.causes().empty() || calibration.quality.cause) continue;
    calibration.quality.cause = g.effect->name;
    findings.doubt(std::string(g.effect->words) +
                   ", by more than is expected of this IMU where the data show it, and they do not show it everywhere");
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
  name_assumed(calibration, findings, effects, covariance, coefficients);
  if (effects.causes().empty()) return;
  std::vector<std::string> words, advice;  // several effects may have one of them
  const auto add = [](std::vector<std::string>& to, std::string text) {
    if (std::ranges::find(to, text) == to.end()) to.push_back(std::move(text));
  };
  for (const std::string& name : effects.causes()) {
    const Effect* const effect = find_effect(name);
    add(words, effect != nullptr ? std::string(effect->words) : name + " is larger");
    if (effect != nullptr) add(advice, std::string(effect->advice));
  }
  quality.cause = fmt::format("{}", fmt::join(effects.causes(), ", "));
  const auto is_cause = [&](const EffectGroup& g) { return std::ranges::find(effects.causes(), g.effect->name) != effects.causes().end(); };
  const bool widened = std::ranges::any_of(effects.groups(), [&](const EffectGroup& g) { return g.widened > 1 && is_cause(g); });
  if (widened) findings.doubt(fmt::format("{}, by more than is expected of this IMU", fmt::join(words, ", or ")));
  if (effects.causes().size() > 1 && !advice.empty())
    findings.warn(fmt::format("the data do not tell these apart: {}; to do so: {}", *quality.cause, fmt::join(advice, ", or ")));
}

}  // namespace imulab::kernel
