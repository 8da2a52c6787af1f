#include "imulab/navigation/aided/start.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace imulab::aided {
namespace {

constexpr int headings = 12;
constexpr double heading_sigma = 30 * unit::deg, tilt_sigma = 5 * unit::deg;  // of a candidate
constexpr double velocity_sigma_at_start = 2, position_sigma_at_start = 30;   // m/s, m: besides what is stated
constexpr double decided = 12;                                                // of ln likelihood: odds of 1 to 160,000

/// What a receiver says of the first seconds.
struct Fixes {
  std::optional<Vector3d> position, velocity, acceleration;
  double time = 0;
};
Fixes first_fixes(const Problem& p, double begin) {
  Fixes out;
  constexpr double span = 2;  // s: of a mean acceleration
  std::optional<double> first_velocity;
  for (const Observation& o : p.observations) {
    const AidRecord& r = p.channels[o.channel].aid.record;
    if (o.withheld || p.channels[o.channel].aid.kind != AidKind::gnss || o.stamp < begin) continue;
    if (!out.position && !r.position.empty() && r.position[o.row].allFinite()) out.position = r.position[o.row], out.time = o.stamp;
    if (r.velocity.empty() || !r.velocity[o.row].allFinite()) continue;
    if (!out.velocity) out.velocity = r.velocity[o.row], first_velocity = o.stamp;
    if (o.stamp - *first_velocity >= span) {
      out.acceleration = (r.velocity[o.row] - *out.velocity) / (o.stamp - *first_velocity);
      break;
    }
  }
  return out;
}

/// The mean specific force of the first seconds, in the body axes of their middle.
Vector3d mean_force(const Problem& p, std::size_t from, double span) {
  Vector3d sum = Vector3d::Zero();
  Matrix3d turned = Matrix3d::Identity(), middle = turned;
  double length = 0;
  for (std::size_t i = from; i < p.samples.size() && length < span; ++i) {
    sum += turned * p.samples[i].increment.velocity;
    turned = turned * rotation_exp(p.samples[i].increment.angle);
    length += p.samples[i].interval;
    if (length < span / 2) middle = turned;
  }
  return sum / length;
}

FilterStart candidate(const Problem& p, const Fixes& fixes, const NavigationState& at, double heading, std::size_t sample) {
  FilterStart out = start_near(p, at);
  out.sample = sample;
  const Vector3d force = mean_force(p, sample, 2), gravity(0, 0, local_earth(at.latitude, at.height).gravity.norm());
  const Vector3d forward(std::sin(heading), std::cos(heading), 0);
  const Matrix3d C = rotation_from_directions(gravity + fixes.acceleration.value_or(Vector3d::Zero()), forward, force, Vector3d::UnitY());
  out.mean.motion.q_nb = Eigen::Quaterniond(C);
  return out;
}

double heading_of(const NavigationState& s) { return euler_angles(s.q_nb.toRotationMatrix()).heading; }

NavigationState known_state(const Fixes& fixes, const Session& session) {
  NavigationState s;
  if (fixes.position) {
    s.latitude = fixes.position->x(), s.longitude = fixes.position->y(), s.height = fixes.position->z();
  } else if (session.initial) {
    s.latitude = session.initial->latitude, s.longitude = session.initial->longitude, s.height = session.initial->height;
  } else if (session.site.latitude) {
    s.latitude = *session.site.latitude, s.longitude = session.site.longitude.value_or(0), s.height = session.site.height.value_or(0);
  } else {
    throw Error("start of navigation: no aid has a position, and the session has neither an initial state nor a site; expected one of them");
  }
  if (fixes.velocity)
    s.velocity = *fixes.velocity;
  else if (session.initial)
    s.velocity = {session.initial->velocity_enu[0], session.initial->velocity_enu[1], session.initial->velocity_enu[2]};
  return s;
}

/// The first sample after a time.
std::size_t sample_after(const Problem& p, double time) {
  if (time < p.begin - p.interval / 2 || time >= p.time.back())
    throw Error(fmt::format("start of navigation: the initial state is at {:.6f} s; expected inside the recording, {:.6f} s to {:.6f} s", time,
                            p.begin, p.time.back()));
  return static_cast<std::size_t>(std::ranges::upper_bound(p.time, time + p.interval / 2) - p.time.begin());
}

}  // namespace

FilterStart start_near(const Problem& p, const NavigationState& state) {
  const Prior prior = prior_of(p);
  FilterStart out{.mean = {state, prior.mean}, .sigma = prior.sigma, .sample = 0};
  out.sigma.segment<3>(At::attitude) << tilt_sigma, tilt_sigma, heading_sigma;
  out.sigma.segment<3>(At::velocity).setConstant(velocity_sigma_at_start);
  out.sigma.segment<3>(At::position).setConstant(position_sigma_at_start);
  return out;
}

FoundStart find_start(const Problem& p, const Session& session) {
  const std::size_t sample = session.initial ? sample_after(p, session.initial->time) : 0;
  const Fixes fixes = first_fixes(p, sample > 0 ? p.time[sample - 1] : p.begin);
  const NavigationState state = known_state(fixes, session);
  if (session.initial) {
    FilterStart start = candidate(p, fixes, state, session.initial->heading, sample);
    start.mean.motion.q_nb = Eigen::Quaterniond(attitude_matrix({session.initial->roll, session.initial->pitch, session.initial->heading}));
    start.sigma.segment<3>(At::attitude) << tilt_sigma, tilt_sigma, tilt_sigma;
    return {std::move(start)};
  }
  struct Candidate {
    FilterStart start;
    double log_likelihood = 0, heading = 0;  // at the end of the data
  };
  std::vector<Candidate> left;
  for (int k = 0; k < headings; ++k) left.push_back({candidate(p, fixes, state, 2 * std::numbers::pi * k / headings, 0)});
  FoundStart out{.start = left.front().start, .candidates = headings};
  for (double span = 20; left.size() > 1; span *= 2) {
    const auto end = static_cast<std::size_t>(std::upper_bound(p.time.begin(), p.time.end(), p.begin + span) - p.time.begin());
    for (Candidate& c : left) {
      const FilterPass pass = filter(p, c.start, {.end = end, .keep = false});
      c.log_likelihood = pass.log_likelihood, c.heading = heading_of(pass.nodes.back().reference.motion);
    }
    std::ranges::sort(left, std::greater<>(), &Candidate::log_likelihood);
    std::erase_if(left, [&](const Candidate& c) { return !(c.log_likelihood >= left.front().log_likelihood - decided); });
    out.seconds = span;
    if (end == p.time.size()) break;
    // Neighbors that agree describe one heading: the filter about the best one has it.
    if (left.size() <= 3 && span >= 80) {
      const double best = heading_of(left.front().start.mean.motion);
      if (std::ranges::all_of(left, [&](const Candidate& c) {
            return std::abs(std::remainder(heading_of(c.start.mean.motion) - best, 2 * std::numbers::pi)) < 35 * unit::deg;
          }))
        break;
    }
  }
  out.start = left.front().start;
  double weights = 0, squares = 0;
  for (const Candidate& c : left) {
    constexpr double overstated = 4;  // a filter that linearizes about a wrong heading learns from what says nothing
    const double weight = std::exp((c.log_likelihood - left.front().log_likelihood) / overstated);
    weights += weight, squares += weight * std::pow(std::remainder(c.heading - left.front().heading, 2 * std::numbers::pi), 2);
  }
  out.spread = std::sqrt(squares / weights);
  return out;
}

}  // namespace imulab::aided
