#include "imulab/navigation/aided/plausible.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;

constexpr double far_level = 4.5;   // in sizes of a slow error: a Gaussian one exceeds it with p = 1e-5
constexpr double far_constant = 5;  // in sigmas of a prior
constexpr double shaking = 50;      // times the declared noise: a car on a road has ten
constexpr double wrong = 20;        // times an aid's usual noise: a receiver between houses has ten
constexpr std::array axis_names{"east", "north", "up"};

std::string place_of(const Channel& c) { return c.aid.file.empty() ? c.name : fmt::format("{} ({})", c.name, c.aid.file); }

}  // namespace

void find_runs_of_suspects(AidedNavigation& n) {
  struct Run {
    double begin = 0, end = -INFINITY, last = -INFINITY;  // times of suspects; time of the last value
    std::size_t values = 0;
  };
  constexpr std::size_t many = 10;
  std::vector<Run> now(n.factors.size()), longest = now;
  for (const AidedInnovation& i : n.innovations) {
    Run& run = now[i.source];
    if (i.time > run.last && run.end < run.last) run.values = 0;  // no component of the last value was a suspect
    run.last = i.time;
    if (!i.suspect) continue;
    if (run.values == 0) run.begin = i.time;
    run.values += i.time > run.end || run.values == 0;
    run.end = i.time;
    if (run.values > longest[i.source].values) longest[i.source] = run;
  }
  for (std::size_t k = 0; k < longest.size(); ++k)
    if (const Run& run = longest[k]; run.values >= many) n.findings.add<Code::suspects_in_a_row>(Subject{n.factors[k].name}, run.begin, run.end);
}

namespace {

/// The least probable change of a slow error within some seconds, in its sigmas.
struct LevelStep {
  double time = 0, change = 0, sigmas = 0;
};
LevelStep largest_step(const std::vector<double>& times, const std::function<double(std::size_t)>& level, double size, double time_constant) {
  constexpr double soon = 3;  // s: the smoothed level changes this quickly at a jump
  LevelStep out;
  for (std::size_t from = 0, to = 1; to < times.size(); ++from) {
    while (to + 1 < times.size() && times[to] - times[from] < soon) ++to;
    const double kept = std::exp((times[from] - times[to]) / time_constant), change = level(to) - kept * level(from);
    if (const double sigmas = std::abs(change) / (size * std::sqrt(1 - kept * kept)); kept < 1 && sigmas > out.sigmas)
      out = {times[to], change, sigmas};
    if (from + 1 == to) ++to;
  }
  return out;
}

/// Adds to `out` what is improbable in the level of a slow error; returns true if anything is. `size`: its stationary sigma.
bool contradicts(const Channel& c, const std::vector<double>& times, const std::function<double(std::size_t)>& level, double size,
                 double time_constant, Index axis, AidedNavigation& out) {
  std::size_t worst = 0;
  for (std::size_t k = 1; k < times.size(); ++k)
    if (std::abs(level(k)) > std::abs(level(worst))) worst = k;
  const LevelStep step = largest_step(times, level, size, time_constant);
  const bool far = std::abs(level(worst)) > far_level * size;
  if (!far && !(step.sigmas > far_level)) return false;
  const double by = far ? level(worst) : step.change;
  const std::string place = place_of(c);
  const char* const kind = far ? "off" : "more than before";
  const double time = far ? times[worst] : step.time, sizes = far ? std::abs(by) / size : step.sigmas;
  if (c.aid.kind == AidKind::gnss)
    out.findings.add<Code::position_level>(Subject{place}, std::abs(by), axis_names[static_cast<std::size_t>(axis)], kind, time, sizes);
  else
    out.findings.add<Code::aid_level>(Subject{place}, kind, time, sizes);
  return true;
}

}  // namespace

void widen_by_levels(const Problem& p, const SmootherPass& smoothed, AidedNavigation& out) {
  std::vector<double> times;
  for (const SmoothedNode& node : smoothed.nodes) times.push_back(p.time_after(node.samples));
  for (const Channel& c : p.channels) {
    if (c.slow < 0 || !has_record(c.aid.kind)) continue;
    const StateBlock& slow = *std::ranges::find(p.blocks, c.slow, &StateBlock::first);
    const double size = slow.sigma * std::sqrt(p.sources[*slow.noise].factor);
    for (Index axis = 0; axis < slow.size; ++axis) {
      const auto level = [&](std::size_t k) { return smoothed.nodes[k].state.x[c.slow + axis]; };
      if (!contradicts(c, times, level, size, slow.time, axis, out) || c.aid.kind != AidKind::gnss) continue;
      // The deviation lasts as long as the slow error: a jump passes through zero.
      std::vector<double> around(times.size());
      for (std::size_t k = 0; k < around.size(); ++k)
        around[k] = k > 0 ? std::max(std::abs(level(k)), around[k - 1] * std::exp((times[k - 1] - times[k]) / slow.time)) : std::abs(level(k));
      for (std::size_t k = around.size() - 1; k-- > 0;)
        around[k] = std::max(around[k], around[k + 1] * std::exp((times[k] - times[k + 1]) / slow.time));
      std::size_t k = 0;
      for (AidedCovariance& covariance : out.covariance) {
        while (k + 1 < times.size() && times[k] < covariance.time) ++k;
        covariance.value(At::position + axis, At::position + axis) += around[k] * around[k];
      }
    }
  }
}

namespace {

/// Returns true if records have the same positions: one receiver, whose errors count once.
bool same_positions(const AidRecord& a, const AidRecord& b) {
  constexpr double equal = 1e-10;  // rad: less than a millimeter
  constexpr std::size_t fewest = 5;
  if (b.position.size() != b.time.size()) return false;  // a record with only velocities has no positions
  std::size_t common = 0, same = 0, j = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    j = static_cast<std::size_t>(std::lower_bound(b.time.begin() + static_cast<std::ptrdiff_t>(j), b.time.end(), a.time[i]) - b.time.begin());
    if (j == b.time.size()) break;
    if (b.time[j] != a.time[i] || !(a.position[i] - b.position[j]).allFinite()) continue;
    ++common, same += (a.position[i] - b.position[j]).head<2>().cwiseAbs().maxCoeff() < equal;
  }
  return common >= fewest && 2 * same > common;
}

/// Returns the largest ratio of an aid's noise, or of its slow error, to its usual size.
double times_usual(const Problem& p, const Channel& c) {
  const AidRecord& r = c.aid.record;
  const AidLaw& law = aid_law(c.aid.kind);
  const auto times = [&](const auto& values, double usual, std::size_t source, const auto& sigma) {
    std::vector<double> all;
    for (std::size_t i = 0; i < values.size(); ++i) all.push_back(sigma(c.aid, i));
    return all.empty() ? 0 : median(std::move(all)) * std::sqrt(p.sources[source].factor) / usual;
  };
  double slow = 0;
  if (c.slow >= 0) {
    const StateBlock& b = *std::ranges::find(p.blocks, c.slow, &StateBlock::first);
    slow = b.sigma * std::sqrt(p.sources[*b.noise].factor) / std::max({b.sigma, law.position_sigma, law.value_sigma});
  }
  return std::max({slow,
                   times(r.position, law.position_sigma, c.first_noise, [](const Aid& aid, std::size_t i) { return position_sigma(aid, i).mean(); }),
                   times(r.velocity, law.velocity_sigma, c.second_noise, [](const Aid& aid, std::size_t i) { return velocity_sigma(aid, i).mean(); }),
                   times(r.value, law.value_sigma, c.first_noise, value_sigma)});
}

}  // namespace

void judge_estimates(const Problem& p, const SmoothedNode& last, AidedNavigation& out) {
  const auto is_used = [&](const Observation& o) { return !o.withheld && has_record(p.channels[o.channel].aid.kind); };
  if (const bool none = std::ranges::none_of(p.observations, is_used); none && std::ranges::any_of(p.observations, &Observation::withheld))
    out.findings.add<Code::all_withheld>();
  else if (none)
    out.findings.add<Code::no_position_aid>();
  const Prior prior = prior_of(p);
  for (const Channel& c : p.channels) {
    for (const Channel& before : p.channels)
      if (&before < &c && same_positions(before.aid.record, c.aid.record))
        out.findings.add<Code::same_receiver>(Subject{place_of(c)}, place_of(before));
    if (const double times = times_usual(p, c); times > wrong) out.findings.add<Code::aid_off>(Subject{place_of(c)}, times, aid_law(c.aid.kind).name);
    for (const StateBlock& b : p.blocks) {
      const bool own = (c.lever >= 0 && b.first == c.lever) || (c.delay >= 0 && b.first == c.delay);
      for (Index k = b.first; own && k < b.first + b.size; ++k) {
        // If data agree with a prior, their change of the estimate has the variance by which they reduce the prior's.
        constexpr double learned = 0.05;  // fraction of the variance: less is rounding
        const double off = std::abs(last.state.x[k] - prior.mean[k]), declared = b.prior[k - b.first] * b.prior[k - b.first];
        const double added = declared - last.variance[k];
        if (added > learned * declared && off > far_constant * std::sqrt(added))
          out.findings.add<Code::constant_off>(Subject{in_words(b.name)}, off, off / std::sqrt(added));
      }
    }
  }
  for (const std::size_t source : {p.gyro_source, p.accel_source})
    if (const double times = std::sqrt(out.factors[source].factor); times > shaking)
      out.findings.add<Code::imu_noise_off>(Subject{source == p.gyro_source ? "gyros" : "accelerometers"}, times);
}

}  // namespace imulab::aided
