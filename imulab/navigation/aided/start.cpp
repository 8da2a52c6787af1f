#include "imulab/navigation/aided/start.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/pose.hpp"
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
constexpr double heading_sigma = 30 * unit::deg, tilt_sigma = 5 * unit::deg;  // one sigma of a candidate
constexpr double velocity_sigma_at_start = 2, position_sigma_at_start = 30;   // m/s, m: in addition to stated sigmas
constexpr double unknown_velocity = 20, unknown_acceleration = 1.5;           // m/s, m/s^2: if no fix determines them
constexpr double prompt = 2;                                                  // s: an earlier fix counts as one at the start
constexpr double decided = 12;                                                // difference of ln likelihood: odds of 1 to 160,000

/// The measurements of receivers at their first position or, if there are no positions, at their first velocity.
struct Fixes {
  std::optional<Vector3d> position, velocity, acceleration;
  double time = INFINITY;     // time of the first fix
  double velocity_noise = 0;  // m/s: one sigma
};

Fixes first_fixes(const Problem& p, double begin) {
  Fixes out;
  constexpr double span = 2, longest = 10;  // s: of a mean acceleration or velocity
  double first_velocity = 0;
  for (const Observation& o : p.observations) {
    const Aid& aid = p.channels[o.channel].aid;
    const AidRecord& r = aid.record;
    if (o.withheld || aid.kind != AidKind::gnss || o.stamp < begin) continue;
    if (out.position && o.stamp - out.time > longest) break;
    const bool place = !r.position.empty() && r.position[o.row].allFinite(), velocity = !r.velocity.empty() && r.velocity[o.row].allFinite();
    if (place && !out.position) {  // an earlier velocity belongs to another time
      out = {.position = r.position[o.row], .velocity = {}, .acceleration = {}, .time = o.stamp};
    } else if (place && !out.velocity && !velocity && o.stamp - out.time >= span) {
      const double length = o.stamp - out.time;
      out.velocity = minus(at_place(r.position[o.row]), at_place(*out.position)).segment<3>(At::position) / length;
      out.velocity_noise = std::numbers::sqrt2 * position_sigma(aid, o.row).maxCoeff() / length;
      break;
    }
    if (!velocity) continue;
    if (!out.velocity) {
      out.velocity = r.velocity[o.row], first_velocity = o.stamp, out.velocity_noise = velocity_sigma(aid, o.row).maxCoeff();
      if (!out.position) out.time = o.stamp;
    } else if (!out.acceleration && o.stamp - first_velocity >= span) {
      out.acceleration = (r.velocity[o.row] - *out.velocity) / (o.stamp - first_velocity);
      if (out.position) break;
    }
  }
  return out;
}

/// Returns the mean specific force of the first seconds in the body axes of their middle.
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

double heading_of(const NavigationState& s) { return euler_angles(s.q_nb.toRotationMatrix()).heading; }

/// Returns the first sample after a time.
std::size_t sample_after(const Problem& p, double time) {
  return static_cast<std::size_t>(std::ranges::upper_bound(p.time, time + p.interval / 2) - p.time.begin());
}

double time_before(const Problem& p, std::size_t sample) { return sample > 0 ? p.time[sample - 1] : p.begin; }

/// Returns true if the unit rests from `begin` to the first fix, which is also at rest.
bool resting(const Problem& p, double begin, const Fixes& fixes) {
  constexpr double sigmas = 6, slow = 0.3, gap = 1.5;  // m/s; s: between two rows of a rest, and before the first
  if (!fixes.velocity || fixes.velocity->norm() > sigmas * fixes.velocity_noise + slow) return false;
  double until = begin;
  for (const Observation& o : p.observations)
    if (p.channels[o.channel].aid.kind == AidKind::zero_velocity && o.stamp > until && o.stamp - until < gap) until = o.stamp;
  return fixes.time - until < gap;
}

/// The known start: state and time, with uncertainty.
struct Known {
  NavigationState state;
  std::size_t sample = 0;
  double velocity_sigma = velocity_sigma_at_start, tilt = tilt_sigma;
  Vector3d acceleration = Vector3d::Zero();
  bool late = false;  // the first fix is at another time
  double late_by = 0;
};
Known known_start(const Problem& p, const Session& session, std::size_t sample, const InitialState* given) {
  Known out{.state = {}, .sample = sample};
  double begin = time_before(p, out.sample);
  Fixes fixes = first_fixes(p, begin);
  if (fixes.time >= p.time.back()) fixes = {};
  const bool rests = resting(p, begin, fixes), any = std::isfinite(fixes.time);
  if (any && !given && !rests && fixes.time - begin > prompt) {
    out.sample = sample_after(p, fixes.time), begin = time_before(p, out.sample);
    out.late_by = begin - p.begin;
  }
  out.late = any && given && !rests && fixes.time - begin > prompt;
  if (out.late) fixes = {};
  if (fixes.position) {
    Eigen::Matrix<double, 9, 1> back = Eigen::Matrix<double, 9, 1>::Zero();
    if (fixes.velocity && !rests) back.segment<3>(At::position) = (begin - fixes.time) * *fixes.velocity;
    out.state = plus(at_place(*fixes.position), back);
  } else if (given) {
    out.state = at_place({given->latitude, given->longitude, given->height});
  } else if (session.site.latitude) {
    out.state = at_place({*session.site.latitude, session.site.longitude.value_or(0), session.site.height.value_or(0)});
  } else {
    throw Error("start of navigation: no aid has a position, and the session has neither an initial state nor a site; expected one of them");
  }
  if (fixes.velocity && !rests)
    out.state.velocity = *fixes.velocity, out.velocity_sigma = std::hypot(out.velocity_sigma, fixes.velocity_noise);
  else if (given)
    out.state.velocity = {given->velocity_enu[0], given->velocity_enu[1], given->velocity_enu[2]};
  else if (!rests)
    out.velocity_sigma = unknown_velocity;
  if (fixes.acceleration && !rests)
    out.acceleration = *fixes.acceleration;
  else if (!rests)
    out.tilt = std::hypot(tilt_sigma, unknown_acceleration / local_earth(out.state.latitude, out.state.height).gravity.norm());
  return out;
}

/// Returns a filter start with a heading, leveled after removal of the acceleration.
FilterStart candidate(const Problem& p, const Known& known, double heading) {
  FilterStart out = start_near(p, known.state);
  out.sample = known.sample;
  out.sigma.segment<2>(At::attitude).setConstant(known.tilt);
  out.sigma.segment<3>(At::velocity).setConstant(known.velocity_sigma);
  const Vector3d force = mean_force(p, known.sample, 2), gravity(0, 0, local_earth(known.state.latitude, known.state.height).gravity.norm());
  const Vector3d forward(std::sin(heading), std::cos(heading), 0);
  out.mean.motion.q_nb = Eigen::Quaterniond(rotation_from_directions(gravity + known.acceleration, forward, force, Vector3d::UnitY()));
  return out;
}

/// Returns the candidate with the largest likelihood.
FoundStart best_heading(const Problem& p, const Known& known) {
  struct Candidate {
    FilterStart start;
    double log_likelihood = 0, heading = 0;  // at the end of the data
  };
  std::vector<Candidate> left;
  for (int k = 0; k < headings; ++k) left.push_back({candidate(p, known, 2 * std::numbers::pi * k / headings)});
  FoundStart out{.start = left.front().start, .candidates = headings, .late_by = known.late_by};
  const double begin = time_before(p, known.sample);
  for (double span = 20; left.size() > 1; span *= 2) {
    const auto end = static_cast<std::size_t>(std::upper_bound(p.time.begin(), p.time.end(), begin + span) - p.time.begin());
    for (Candidate& c : left) {
      const FilterPass pass = filter(p, c.start, {.end = end, .keep = false});
      c.log_likelihood = pass.log_likelihood, c.heading = heading_of(pass.nodes.back().reference.motion);
    }
    std::ranges::sort(left, std::greater<>(), &Candidate::log_likelihood);
    std::erase_if(left, [&](const Candidate& c) { return !(c.log_likelihood >= left.front().log_likelihood - decided); });
    out.seconds = span;
    if (end == p.time.size()) break;
    // Adjacent candidates that agree represent one heading, which the filter about the best one can find.
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
    constexpr double overstated = 4;  // a filter that linearizes about a wrong heading gains false information
    const double weight = std::exp((c.log_likelihood - left.front().log_likelihood) / overstated);
    weights += weight, squares += weight * std::pow(std::remainder(c.heading - left.front().heading, 2 * std::numbers::pi), 2);
  }
  out.spread = std::sqrt(squares / weights);
  return out;
}

}  // namespace

FilterStart start_near(const Problem& p, const NavigationState& state) {
  const Prior prior = prior_of(p);
  FilterStart out{.mean = {state, prior.mean}, .sigma = prior.sigma, .sample = 0};
  out.sigma.segment<3>(At::attitude) << tilt_sigma, tilt_sigma, heading_sigma;
  out.sigma.segment<3>(At::velocity).setConstant(velocity_sigma_at_start);
  out.sigma.segment<3>(At::position).setConstant(position_sigma_at_start);
  constexpr double vague = 10;  // factor on a level: the height of a fix must not count as independent knowledge
  for (const Channel& c : p.channels)
    if (c.level >= 0) out.sigma[At::position + 2] = std::max(out.sigma[At::position + 2], vague * prior.sigma[c.level]);
  return out;
}

FoundStart find_start(const Problem& p, const Session& session) {
  if (const std::optional<PoseStart> pose = start_by_poses(p, p.begin)) {
    // One sigma: how the tracked body lies is known to half of the angle; the lever arm and errors of the first pose are below the distance.
    constexpr double angle = 10 * unit::deg, beside_frame = 2;
    FoundStart out{.start = start_near(p, pose->state)};
    out.start.sample = sample_after(p, pose->time);
    out.start.sigma.segment<3>(At::attitude).setConstant(angle);
    out.start.sigma.segment<3>(At::position).setConstant(beside_frame);
    if (const double later = time_before(p, out.start.sample) - p.begin; later > prompt) out.late_by = later;
    return out;
  }
  if (!session.initial) return best_heading(p, known_start(p, session, 0, nullptr));
  const InitialState& given = *session.initial;
  if (given.time < p.begin - p.interval / 2 || given.time >= p.time.back())
    throw Error(fmt::format("start of navigation: the initial state is at {:.6f} s; expected inside the recording, {:.6f} s to {:.6f} s", given.time,
                            p.begin, p.time.back()));
  const Known known = known_start(p, session, sample_after(p, given.time), &given);
  FoundStart out{.start = candidate(p, known, given.heading)};
  out.start.mean.motion.q_nb = Eigen::Quaterniond(attitude_matrix({given.roll, given.pitch, given.heading}));
  out.start.sigma.segment<3>(At::attitude) << tilt_sigma, tilt_sigma, tilt_sigma;
  if (known.late) out.at_fix = best_heading(p, known_start(p, session, known.sample, nullptr)).start;
  return out;
}

}  // namespace imulab::aided
