#include "imulab/navigation/aided/aided.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/navigation/aided/factor_search.hpp"
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/outages.hpp"
#include "imulab/navigation/aided/plausible.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace aided {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double settled_heading = 5 * unit::deg;  // of several starts: a smaller difference is within the sigma

/// The smoothed trajectory as the next point of linearization: constants and offsets by their means, slow errors of aids at zero, in which all is
/// linear.
AboutTrajectory about(const Problem& p, const FilterPass& pass, SmootherPass& smoothed) {
  std::vector<std::size_t> samples;
  std::vector<FullState> states;
  VectorXd mean = VectorXd::Zero(p.size);
  for (std::size_t k = 0; k < pass.nodes.size(); ++k) {
    samples.push_back(pass.nodes[k].samples), states.push_back(smoothed.nodes[k].state);
    mean += states.back().x / static_cast<double>(pass.nodes.size());
  }
  AboutTrajectory out = trajectory_of(p, samples, states);
  for (const StateBlock& b : p.blocks)
    if (std::isfinite(b.time)) mean.segment(b.first, b.size).setZero();
  out.x = mean;
  out.weights = std::move(smoothed.weights);
  return out;
}

/// The state before a sample, from that after it.
NavigationState state_before(const Problem& p, std::size_t sample, const VectorXd& x, const NavigationState& after) {
  NavigationState out = after;
  for (int k = 0; k < 2; ++k) out = plus(out, minus(after, integrate(p, sample, sample + 1, {out, x}, false).end));
  return out;
}

/// A filter that begins long before its first fix linearizes about what it has drifted to by then: the smoothed trajectory from the fix on, carried
/// back to the start. Empty where the filter finds its own.
AboutTrajectory first_trajectory(const Problem& p, const FoundStart& start) {
  if (!start.at_fix) return {};
  const FilterPass pass = filter(p, *start.at_fix);
  SmootherPass smoothed = smooth(p, pass);
  AboutTrajectory out = about(p, pass, smoothed);
  std::vector<NavigationState> back;
  for (std::size_t i = start.at_fix->sample; i-- > start.start.sample;)
    back.push_back(state_before(p, i, out.x, back.empty() ? out.states.front() : back.back()));
  out.states.insert(out.states.begin(), back.rbegin(), back.rend());
  return out;
}

void add_innovations(const Problem& p, const FilterPass& pass, AidedNavigation& out) {
  double squares = 0, doubted = 0;
  std::size_t count = 0;
  for (const Node& node : pass.nodes)
    for (const EpochRows& e : node.rows)
      for (Index k = 0; k < e.innovation.size(); ++k) {
        const double sigmas = e.innovation[k] / std::sqrt(e.innovation_variance[k]);
        out.innovations.push_back({p.observations[e.observation].stamp, e.rows.source[static_cast<std::size_t>(k)], sigmas});
        squares += std::min(sigmas * sigmas, 25.), doubted += e.weight[k] < 1. / 3, ++count;
      }
  if (count == 0) return;
  out.innovation_rms = std::sqrt(squares / static_cast<double>(count));
  out.suspects = doubted / static_cast<double>(count);
}

double time_of(const Problem& p, std::size_t samples) { return samples > 0 ? p.time[samples - 1] : p.begin; }

/// The filter's states between the epochs are integrated from the last one.
void add_solution(const Problem& p, const FilterPass& pass, const std::vector<NavigationState>& states, AidedNavigation& out) {
  const std::size_t first = pass.nodes.front().samples;
  for (std::size_t i = 0; i < states.size(); ++i) out.solution.time.push_back(time_of(p, first + i));
  out.solution.states = states;
}

std::vector<NavigationState> causal_states(const Problem& p, const FilterPass& pass) {
  FullState now = plus(pass.nodes.front().reference, pass.nodes.front().error);
  std::vector<NavigationState> states{now.motion};
  for (std::size_t k = 0; k + 1 < pass.nodes.size(); ++k) {
    integrate(p, pass.nodes[k].samples, pass.nodes[k + 1].samples, now, false, &states);
    now = plus(pass.nodes[k + 1].reference, pass.nodes[k + 1].error);
    states.back() = now.motion;
  }
  return states;
}

/// Where no aid tells the position, a curved Earth is not linear in it, and no map needs it.
void judge_positions(AidedNavigation& out, const std::string& name) {
  constexpr double lost = 1000;  // m
  std::vector<double> all;
  const auto sigma = [](const AidedCovariance& c) {
    return std::sqrt(c.value(At::position, At::position) + c.value(At::position + 1, At::position + 1));
  };
  for (const AidedCovariance& c : out.covariance) all.push_back(sigma(c));
  const AidedCovariance& worst = *std::ranges::max_element(out.covariance, {}, sigma);
  if (sigma(worst) <= lost) return;
  const double typical = median(std::move(all));
  std::string text = fmt::format("the position is lost: its sigma is {:.2g} m (median), {:.2g} m at {:.6g} s; expected positions by an aid", typical,
                                 sigma(worst), worst.time);
  out.warnings.push_back(name + ": " + text);
  if (typical > lost) out.doubts.push_back(std::move(text));
}

void judge(AidedNavigation& out, const std::string& name) {
  const auto doubt = [&](std::string text) {
    out.warnings.push_back(name + ": " + text);
    out.doubts.push_back(std::move(text));
  };
  judge_positions(out, name);
  if (const std::string text = hidden_heading(out); !text.empty()) doubt(text);
  if (out.innovation_rms > 1.5)
    doubt(fmt::format("innovations are {:.1f} times their stated size; the aids contradict each other or the recording", out.innovation_rms));
  if (out.suspects > 0.1) doubt(fmt::format("{:.0f} % of the aids' values are suspects", 100 * out.suspects));
  double squares = 0;
  for (const OutageResult& o : out.outages) squares += o.smoothed.ratio * o.smoothed.ratio / static_cast<double>(out.outages.size());
  if (out.outages.size() >= 3 && std::sqrt(squares) > 2)
    doubt(fmt::format("errors in withheld times are {:.1f} times their stated sigma", std::sqrt(squares)));
  if (!out.converged) out.warnings.push_back(fmt::format("{}: the estimates of the noise still change after {} passes", name, out.passes));
}

}  // namespace

AidedNavigation navigate_under(const SensorPriors& priors, const Session& session, const Recording& recording, const std::vector<Aid>& aids,
                               const AidedOptions& options, const OutputTerms* terms) {
  AidedNavigation out;
  std::vector<Aid> measured = aids;
  out.warnings = take_repeats(measured);
  Problem p = make_problem(recording, priors, measured, session, {.outages = options.outages});
  add_first_rest(p, recording, session);
  set_first_factors(p);
  const FoundStart start = find_start(p, session);
  if (!start.said.empty()) out.warnings.push_back(recording.name + ": " + start.said);
  for (const Channel& c : p.channels) out.aids.push_back(c.name);
  out.causal = options.causal, out.headings = start.candidates;
  FilterPass pass;
  SmootherPass smoothed;
  AboutTrajectory trajectory = first_trajectory(p, start);
  FactorSearch search;
  while (out.passes < options.passes && !out.converged) {
    count_iteration(options.passes);
    pass = {}, smoothed = {};  // one at a time in memory
    pass = filter(p, start.start, {.about = trajectory.states.empty() ? nullptr : &trajectory});
    smoothed = smooth(p, pass);
    out.factors.clear();
    for (std::size_t k = 0; k < p.sources.size(); ++k) out.factors.push_back({p.sources[k].name, p.sources[k].factor, smoothed.evidence[k].resolved});
    ++out.passes;
    trajectory = about(p, pass, smoothed);
    if (out.passes == options.passes) break;  // the factors remain those of the states
    out.converged = search.update(p, smoothed.evidence) < settled && out.passes > 2;
  }
  add_outages(p, pass, smoothed, &OutageResult::smoothed, out.outages);
  if (terms)
    add_constants_with(*terms, p, start.start, trajectory, out);
  else
    add_constants(p, smoothed, out);
  std::vector<NavigationState> states = trajectory.states;
  for (std::size_t k = 0; k < pass.nodes.size() && !options.causal; ++k)
    out.covariance.push_back({time_of(p, pass.nodes[k].samples), smoothed.nodes[k].covariance});
  if (!options.causal) add_innovations(p, pass, out);
  std::vector<double> times;
  for (const Node& node : pass.nodes) times.push_back(time_of(p, node.samples));
  pass = {};
  // What was known at each time, with the noise of the whole. A filter that linearizes about its own first states is too sure of its attitude.
  pass = filter(p, start.start, {.about = &trajectory});
  add_outages(p, pass, {}, &OutageResult::predicted, out.outages);
  std::erase_if(out.outages, [](const OutageResult& o) { return o.fixes == 0; });  // nothing was compared
  if (options.causal) {
    add_innovations(p, pass, out);
    states = causal_states(p, pass);
    for (const Node& node : pass.nodes) out.covariance.push_back({time_of(p, node.samples), node.covariance.topLeftCorner<9, 9>()});
  }
  add_solution(p, pass, states, out);
  if (start.spread > settled_heading)
    for (AidedCovariance& c : out.covariance) c.value(2, 2) += start.spread * start.spread;
  judge(out, recording.name);
  if (std::ranges::none_of(p.observations, [&](const Observation& o) { return !o.withheld && has_record(p.channels[o.channel].aid.kind); })) {
    out.doubts.emplace_back("all values of the aids are withheld: nothing corrects the solution");
    out.warnings.push_back(recording.name + ": " + out.doubts.back());
  }
  widen_by_levels(p, times, smoothed, out);
  for (std::string& doubt : implausible_estimates(p, smoothed.nodes.back(), out)) {
    out.warnings.push_back(recording.name + ": " + doubt);
    out.doubts.push_back(std::move(doubt));
  }
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

Eigen::Matrix<double, 9, 9> covariance_at(const AidedNavigation& n, double time) {
  auto after = std::lower_bound(n.covariance.begin(), n.covariance.end(), time, [](const AidedCovariance& c, double t) { return c.time < t; });
  if (after == n.covariance.end()) --after;
  if (after == n.covariance.begin()) return after->value;
  const AidedCovariance& before = *std::prev(after);
  const double part = std::clamp((time - before.time) / (after->time - before.time), 0., 1.);
  return (1 - part) * before.value + part * after->value;
}

Eigen::Matrix<double, 9, 1> sigmas_at(const AidedNavigation& n, double time) { return covariance_at(n, time).diagonal().cwiseMax(0).cwiseSqrt(); }

}  // namespace imulab
