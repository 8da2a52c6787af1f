#include "imulab/navigation/aided/aided.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/clock_search.hpp"
#include "imulab/navigation/aided/factor_search.hpp"
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/lasting.hpp"
#include "imulab/navigation/aided/outages.hpp"
#include "imulab/navigation/aided/plausible.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/navigation/aided/unmeasured.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace imulab {
namespace aided {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int fewest_passes = 3;                   // smallest number of passes that may converge
constexpr int widenings = 5;                       // largest number of widenings for correlated errors
constexpr double settled_heading = 5 * unit::deg;  // for several starts: smaller differences are within the sigma

EpochStates epochs_of(const SmootherPass& smoothed) {
  EpochStates out;
  for (const SmoothedNode& node : smoothed.nodes) out.samples.push_back(node.samples), out.states.push_back(node.state);
  return out;
}

/// Returns the smoothed trajectory as the next linearization: constants and offsets at their means, slow errors of aids at zero (they are linear).
AboutTrajectory about(const Problem& p, SmootherPass& smoothed) {
  VectorXd mean = VectorXd::Zero(p.size);
  for (const SmoothedNode& node : smoothed.nodes) mean += node.state.x / static_cast<double>(smoothed.nodes.size());
  for (const StateBlock& b : p.blocks)
    if (std::isfinite(b.time)) mean.segment(b.first, b.size).setZero();
  return {.at = trajectory_of(p, epochs_of(smoothed)), .x = std::move(mean), .weights = std::move(smoothed.weights)};
}

/// Returns the state before a sample from the state after it.
NavigationState state_before(const Problem& p, std::size_t sample, const VectorXd& x, const NavigationState& after) {
  NavigationState out = after;
  for (int k = 0; k < 2; ++k) out = plus(out, minus(after, integrate(p, sample, sample + 1, {out, x}, false).end));
  return out;
}

/// Returns a trajectory if the filter starts long before the first fix, because it would otherwise linearize about the drift until then: the smoothed
/// trajectory from the fix on, integrated back to the start. Empty if the filter needs none.
AboutTrajectory first_trajectory(const Problem& p, const FoundStart& start) {
  if (!start.at_fix) return {};
  SmootherPass smoothed = smooth(p, filter(p, *start.at_fix));
  AboutTrajectory out = about(p, smoothed);
  const std::size_t fix = start.at_fix->sample;
  std::vector<NavigationState> back;  // from the state before the fix to the start
  for (std::size_t i = fix; i-- > start.start.sample;) back.push_back(state_before(p, i, out.x, back.empty() ? out.at(fix) : back.back()));
  out.at = [fix, back = std::move(back), after = out.at](std::size_t samples) { return samples < fix ? back[fix - samples - 1] : after(samples); };
  return out;
}

/// The results of the filter at its epochs, in order.
struct CausalPass {
  const Problem& p;
  bool solution;            // `epochs` are the solution
  EpochStates epochs = {};  // states of the filter
  std::vector<AidedCovariance> covariance = {};
  std::vector<AidedInnovation> innovations = {};
  std::vector<Withheld> withheld = {};
  double squares = 0, doubted = 0;

  void add(const Matrix9& predicted, const Node& node) {
    for (const EpochRows& e : node.rows)
      for (Index k = 0; k < e.innovation.size(); ++k) {
        const double sigmas = e.innovation[k] / std::sqrt(e.innovation_variance[k]);
        const bool suspect = e.weight[k] < 1. / 3;
        innovations.push_back({p.observations[e.observation].stamp, e.rows.source[static_cast<std::size_t>(k)], sigmas, suspect});
        squares += std::min(sigmas * sigmas, 25.), doubted += suspect;
      }
    for (const EpochRows& e : node.withheld)
      if (!e.rows.source.empty()) withheld.push_back({e.observation, e.rows.source.front(), e.innovation, e.innovation_variance});
    if (!solution) return;
    epochs.samples.push_back(node.samples), epochs.states.push_back(plus(node.reference, node.error));
    if (!node.rows.empty()) covariance.push_back({p.time_after(node.samples), predicted});  // includes the growth until that epoch
    covariance.push_back({p.time_after(node.samples), node.covariance.topLeftCorner<9, 9>()});
  }

  void finish(AidedNavigation& out) {
    add_outages(p, withheld, &OutageResult::predicted, out.outages);
    std::erase_if(out.outages, [](const OutageResult& o) { return o.fixes == 0; });  // nothing was compared
    if (solution) out.covariance = std::move(covariance);
    out.innovations = std::move(innovations);
    if (out.innovations.empty()) return;
    const auto count = static_cast<double>(out.innovations.size());
    out.innovation_rms = std::sqrt(squares / count), out.suspects = doubted / count;
  }
};

/// Returns the states after each sample from epoch k to the next. The filter's states are integrated from the epoch and corrected at the next.
std::vector<NavigationState> solution_between(const Problem& p, const EpochStates& epochs, std::size_t k, bool causal) {
  if (!causal) return states_between(p, epochs, k);
  std::vector<NavigationState> states;
  integrate(p, epochs.samples[k], epochs.samples[k + 1], epochs.states[k], false, &states);
  states.back() = epochs.states[k + 1].motion;
  return states;
}

void add_states(const Problem& p, const EpochStates& epochs, const AidedOptions& options, AidedNavigation& out) {
  constexpr std::size_t places = 5'000;
  const std::size_t first = epochs.samples.front();
  out.states = epochs.samples.back() - first + 1;
  const std::size_t drawn = out.states / places + 1;
  std::size_t taken = 0;
  const auto add = [&](const NavigationState& state) {
    Solution& kept = out.solution;
    const double time = p.time_after(first + taken);
    if (taken > 0) out.distance += (time - kept.time.back()) * state.velocity.norm();
    if (!options.keep && kept.size() == 2) kept.time.pop_back(), kept.states.pop_back();
    kept.time.push_back(time), kept.states.push_back(state);
    if (taken % drawn == 0 || taken + 1 == out.states) out.track.push_back(state);
    if (options.each) options.each(out, time, state);
    ++taken;
  };
  if (options.keep) out.solution.time.reserve(out.states), out.solution.states.reserve(out.states);
  add(epochs.states.front().motion);
  for (std::size_t k = 0; k + 1 < epochs.samples.size(); ++k)
    for (const NavigationState& state : solution_between(p, epochs, k, options.causal)) add(state);
}

/// Warns if no aid determines the position: the equations are nonlinear in it on a curved Earth, and the position is useless on a map.
void judge_positions(AidedNavigation& out) {
  constexpr double lost = 1000;  // m
  std::vector<double> all;
  const auto sigma = [](const AidedCovariance& c) {
    return std::sqrt(std::max(0., c.value(At::position, At::position)) + std::max(0., c.value(At::position + 1, At::position + 1)));  // by rounding
  };
  for (const AidedCovariance& c : out.covariance)
    if (&c == &out.covariance.back() || c.time < (&c + 1)->time) all.push_back(sigma(c));  // a time counts once
  const AidedCovariance& worst = *std::ranges::max_element(out.covariance, {}, sigma);
  if (sigma(worst) <= lost) return;
  const double typical = median(std::move(all));
  Finding& found = out.findings.add<Code::position_lost>(sigma(worst), worst.time, typical);
  if (typical > lost) found.severity = Severity::doubt;
}

std::vector<MotionResiduals> residuals_of(const SmootherPass& smoothed) {
  const auto residuals = [](const NoiseEvidence& e) { return AidedResiduals{e.resolved > 0 ? std::sqrt(e.squares / e.resolved) : 0, e.resolved}; };
  std::vector<MotionResiduals> out;
  for (std::size_t kind = 0; kind < motion_kinds.size(); ++kind)
    out.push_back({motion_kinds[kind], residuals(smoothed.motion[kind].gyro), residuals(smoothed.motion[kind].accel)});
  return out;
}

void judge_gyro_delay(AidedNavigation& out) {
  constexpr double certain = 5, least = 2e-3;  // sigmas; s: of a delay that matters
  for (const AidedConstant& c : out.constants)
    if (c.name == "imu.gyro_delay" && std::abs(c.value) > std::max(least, certain * c.sigma))
      out.findings.add<Code::triads_delayed>(-1e3 * c.value, 1e3 * c.sigma);
}

void judge(AidedNavigation& out) {
  judge_gyro_delay(out);
  judge_positions(out);
  judge_heading(out);
  if (out.innovation_rms > 1.5) out.findings.add<Code::large_innovations>(out.innovation_rms);
  if (out.suspects > 0.1) out.findings.add<Code::many_suspects>(100 * out.suspects);
  find_runs_of_suspects(out);
  for (const AidedFactor& f : out.factors)
    if (f.lasting > 1) out.findings.add<Code::long_errors>(Subject{f.name}, f.lasting);
  judge_lasting(out);
  double squares = 0;
  for (const OutageResult& o : out.outages) squares += o.smoothed.ratio * o.smoothed.ratio / static_cast<double>(out.outages.size());
  if (out.outages.size() >= 3 && std::sqrt(squares) > 2) out.findings.add<Code::outages_off>(std::sqrt(squares));
  if (!out.converged) out.findings.add<Code::noise_still_changes>(out.passes);
}

}  // namespace

AidedNavigation navigate_under(const SensorPriors& priors, const Session& session, const Recording& recording, const std::vector<Aid>& aids,
                               const AidedOptions& options, const OutputTerms* terms) {
  AidedNavigation out;
  std::vector<Aid> measured = aids;
  take_unmeasured(measured, session, recording, out);
  find_clocks(measured, recording, options.outages, out);
  Problem p = make_problem(recording, priors, measured, session, {.outages = options.outages});
  add_first_rest(p, recording, session);
  set_first_factors(p);
  const FoundStart start = find_start(p, session);
  if (start.late_by > 0) out.findings.add<Code::late_start>(start.late_by).place = recording.name;
  for (const Channel& c : p.channels) out.aids.push_back(c.name);
  out.causal = options.causal, out.headings = start.candidates;
  SmootherPass smoothed;
  std::optional<CausalPass> known;
  AboutTrajectory trajectory = first_trajectory(p, start);
  FactorSearch search;
  const auto pass = [&](bool covariances) {
    smoothed = {}, known.emplace(CausalPass{p, options.causal});  // only one of them in memory at a time
    FilterPass filtered = filter(p, start.start,
                                 {.about = trajectory.at ? &trajectory : nullptr,
                                  .each = [&](const Transition*, const Matrix9& predicted, const Node& node) { known->add(predicted, node); }});
    smoothed = smooth(p, std::move(filtered), covariances);
  };
  while (true) {
    count_iteration(options.passes);
    pass(out.passes + 1 >= std::min(fewest_passes, options.passes));
    out.factors.clear();
    for (std::size_t k = 0; k < p.sources.size(); ++k) out.factors.push_back({p.sources[k].name, p.sources[k].factor, smoothed.evidence[k].resolved});
    if (++out.passes == options.passes) break;  // the factors remain those of the states
    out.converged = search.update(p, smoothed.evidence) < settled && out.passes >= fewest_passes;
    if (out.converged) break;
    trajectory = about(p, smoothed);
  }
  use_factors(out, p);
  for (int round = 0; round < widenings; ++round) {
    out.innovations = known->innovations;
    if (!widen_lasting(p, out)) break;
    use_factors(out, p);
    trajectory = about(p, smoothed);
    pass(true);
  }
  out.residuals = residuals_of(smoothed);
  add_outages(p, smoothed.withheld, &OutageResult::smoothed, out.outages);
  if (terms)
    add_constants_with(*terms, p, start.start, trajectory = about(p, smoothed), out);
  else
    add_constants(p, smoothed, out);
  if (!options.causal)
    for (const SmoothedNode& node : smoothed.nodes) out.covariance.push_back({p.time_after(node.samples), node.covariance});
  // The covariance of a causal solution also comes from the last pass: a filter that linearizes about its own first states is overconfident.
  known->finish(out);
  if (start.spread > settled_heading)
    for (AidedCovariance& c : out.covariance) c.value(2, 2) += start.spread * start.spread;
  const auto of_recording = [&](std::size_t first) {
    for (; first < out.findings.size(); ++first) out.findings[first].place = recording.name;
  };
  const std::size_t before = out.findings.size();
  judge(out);
  of_recording(before);
  widen_by_levels(p, smoothed, out);
  const std::size_t after = out.findings.size();
  judge_estimates(p, smoothed.nodes.back(), out);
  of_recording(after);
  add_states(p, options.causal ? known->epochs : epochs_of(smoothed), options, out);
  return out;
}

}  // namespace aided

AidedNavigation navigate_aided(const Calibration& calibration, const Session& session, Recording raw, const std::vector<Aid>& aids,
                               const AidedOptions& options) {
  Session checked = session;
  checked.aids = aids;
  validate(checked), validate(raw);
  Recording recording = compensate(calibration.model, std::move(raw)).recording;
  if (!calibration.model.lever_arm.isZero(0)) remove_lever_arms(recording, calibration.model.lever_arm);
  return aided::navigate_under(aided::sensor_priors(calibration, session.imu), session, recording, aids, options);
}

namespace {

/// The epochs adjacent to a time, and the fraction of the way to the second. The first of two epochs at one time is before an update.
struct Neighbors {
  const AidedCovariance &before, &after;
  double part = 0;
};
Neighbors neighbors(const AidedNavigation& n, double time) {
  const auto after = std::ranges::upper_bound(n.covariance, time, {}, &AidedCovariance::time);
  if (after == n.covariance.end()) return {n.covariance.back(), n.covariance.back()};
  if (after == n.covariance.begin()) return {*after, *after};
  const AidedCovariance& before = *std::prev(after);
  return {before, *after, std::clamp((time - before.time) / (after->time - before.time), 0., 1.)};
}

}  // namespace

Eigen::Matrix<double, 9, 9> covariance_at(const AidedNavigation& n, double time) {
  const auto [before, after, part] = neighbors(n, time);
  return (1 - part) * before.value + part * after.value;
}

Eigen::Matrix<double, 9, 1> sigmas_at(const AidedNavigation& n, double time) {
  const auto [before, after, part] = neighbors(n, time);
  return ((1 - part) * before.value.diagonal() + part * after.value.diagonal()).cwiseMax(0).cwiseSqrt();
}

}  // namespace imulab
