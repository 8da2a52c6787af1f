#include "imulab/navigation/aided/clock_search.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/inertial_samples.hpp"
#include "imulab/recording/aid_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::aided {
namespace {

constexpr double finest_interval = 0.5, least_common = 30;  // s: of an interval, and of the compared time
constexpr std::size_t most_bins = 8000;                     // largest number of intervals of a record: the time grows with their square
constexpr double alike_for = 4;                             // s: rates within this time are correlated
constexpr double decisive = 12;                             // difference of ln likelihood: odds of 1 to 160,000
constexpr double between_maxima = 5;                        // s: closer offsets belong to the same maximum

/// Motion in intervals of equal length; NaN if nothing was measured.
struct BinnedMotion {
  double begin = 0;                // s
  std::vector<double> turn, push;  // rad/s about the vertical; m/s^2, horizontal
};

/// Computes the motion from the IMU. The vertical in body axes is the mean force of 20 s: a vehicle turns about it and seldom leaves it longer.
BinnedMotion motion_by_imu(const Recording& recording, double length) {
  BinnedMotion out{.begin = recording.time_s(0), .turn = {}, .push = {}};
  const auto count = static_cast<std::size_t>((recording.time_s(recording.size() - 1) - out.begin) / length) + 1;
  std::vector<Vector3d> angle(count, Vector3d::Zero()), velocity = angle;
  std::vector<double> time(count, 0);
  for_each_increment(recording, {0, recording.size()}, [&](const TimedIncrement& step, double end) {
    const double middle = end - step.interval / 2 - out.begin;
    const std::size_t k = middle > 0 ? std::min(count - 1, static_cast<std::size_t>(middle / length)) : 0;
    angle[k] += step.increment.angle, velocity[k] += step.increment.velocity, time[k] += step.interval;
  });
  const auto half = static_cast<std::size_t>(10 / length) + 1;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < std::min(half, count); ++k) sum += velocity[k];
  for (std::size_t k = 0; k < count; ++k) {
    if (k + half < count) sum += velocity[k + half];
    if (k > half) sum -= velocity[k - half - 1];
    const Vector3d up = sum.normalized(), force = velocity[k] / time[k];
    out.turn.push_back(angle[k].dot(up) / time[k]), out.push.push_back((force - force.dot(up) * up).norm());
  }
  return out;
}

struct TimedVelocity {
  double time = 0;
  Eigen::Vector2d value;  // east, north [m/s]
};

/// Returns measured velocities, or differences of successive positions.
std::vector<TimedVelocity> velocities_of(const Aid& aid, const std::vector<Outage>& withheld) {
  const AidRecord& r = aid.record;
  std::vector<TimedVelocity> out;
  std::size_t before = r.time.size();
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const double t = 1e-9 * static_cast<double>(r.time[i]);
    const auto in = [t](const Outage& o) { return t >= o.begin && t < o.end; };
    if (std::ranges::any_of(withheld, in) || std::ranges::any_of(aid.outages, in)) continue;
    if (!r.velocity.empty()) {
      if (const Eigen::Vector2d v = r.velocity[i].head<2>(); v.allFinite()) out.push_back({t, v});
    } else if (!r.position.empty() && r.position[i].allFinite()) {
      if (const std::size_t last = std::exchange(before, i); last < r.time.size()) {
        const double from = 1e-9 * static_cast<double>(r.time[last]);
        const Eigen::Vector3d way = minus(at_place(r.position[i]), at_place(r.position[last])).segment<3>(At::position);
        out.push_back({(from + t) / 2, way.head<2>() / (t - from)});
      }
    }
  }
  return out;
}

BinnedMotion motion_by_receiver(const std::vector<TimedVelocity>& all, double interval, double length) {
  BinnedMotion out{.begin = all.front().time, .turn = {}, .push = {}};
  const auto count = static_cast<std::size_t>((all.back().time - out.begin) / length) + 1;
  std::vector<Eigen::Vector2d> v(count, Eigen::Vector2d::Constant(NAN));
  std::size_t next = 1;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = out.begin + (static_cast<double>(k) + 0.5) * length;
    while (next + 1 < all.size() && all[next].time < t) ++next;
    const TimedVelocity &a = all[next - 1], &b = all[next];
    if (t >= a.time && t <= b.time && b.time - a.time < 2.5 * interval) v[k] = a.value + (t - a.time) / (b.time - a.time) * (b.value - a.value);
  }
  constexpr double slow = 1;  // m/s: below this speed, a course is noise
  for (std::size_t k = 0; k < count; ++k) {
    const bool inner = k > 0 && k + 1 < count;
    const Eigen::Vector2d a = inner ? Eigen::Vector2d((v[k + 1] - v[k - 1]) / (2 * length)) : Eigen::Vector2d::Constant(NAN);
    out.turn.push_back((v[k].x() * a.y() - v[k].y() * a.x()) / (v[k].squaredNorm() + slow * slow));
    out.push.push_back(a.norm());
  }
  return out;
}

/// Returns the log likelihood ratio of b, shifted by `by` intervals, explained by a, to b without explanation.
double explained(const std::vector<double>& a, const std::vector<double>& b, std::ptrdiff_t by, double length) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -by), end = std::min(std::ssize(b), std::ssize(a) - by);
  for (std::ptrdiff_t k = begin; k < end; ++k) {
    const double u = a[static_cast<std::size_t>(k + by)], v = b[static_cast<std::size_t>(k)];
    if (!std::isfinite(u + v)) continue;
    n += 1, x += u, y += v, xx += u * u, yy += v * v, xy += u * v;
  }
  const double vx = xx - x * x / n, vy = yy - y * y / n, covariance = xy - x * y / n;
  if (!(n * length >= least_common / 2 && vx > 0 && vy > 0 && covariance > 0)) return 0;
  constexpr double best = 1 - 1e-6;  // limit of the squared correlation
  return -0.5 * n * std::min(1., length / alike_for) * std::log1p(-std::min(best, covariance * covariance / (vx * vy)));
}

struct Offset {
  double by = 0, likelihood = -HUGE_VAL;  // s, to be added to the stamps
};

/// Returns all offsets that leave half of the shorter record in common.
std::vector<Offset> offsets(const BinnedMotion& imu, const BinnedMotion& receiver, double length, double other_scale) {
  const std::ptrdiff_t I = std::ssize(imu.turn), R = std::ssize(receiver.turn), common = std::min(I, R) / 2;
  std::vector<Offset> out;
  for (std::ptrdiff_t k = common - R; k <= I - common; ++k) {
    Offset o{imu.begin + static_cast<double>(k) * length - receiver.begin,
             explained(imu.turn, receiver.turn, k, length) + explained(imu.push, receiver.push, k, length)};
    const double from_dates = std::min(std::abs(o.by), std::abs(o.by - other_scale));
    if (other_scale > 0 && from_dates > guessed_offset_sigma + length) o.likelihood -= decisive;
    out.push_back(o);
  }
  return out;
}

/// Returns the best of all offsets, interpolated between intervals.
Offset refined(const std::vector<Offset>& all, const Offset& best, double length) {
  Offset out = best;
  const std::ptrdiff_t k = &best - all.data();
  if (k == 0 || k + 1 == std::ssize(all)) return out;
  const double before = all[static_cast<std::size_t>(k - 1)].likelihood, after = all[static_cast<std::size_t>(k + 1)].likelihood;
  if (const double curvature = before + after - 2 * best.likelihood; curvature < 0) out.by += length * 0.5 * (before - after) / curvature;
  return out;
}

std::string scale_text(double by, double other_scale) {
  return other_scale > 0 && std::abs(by - other_scale) <= guessed_offset_sigma ? "; the recording then counts GPS time: time = { scale = \"gps\" }"
         : other_scale > 0 && std::abs(by) <= guessed_offset_sigma             ? "; the recording then counts UTC: time = { scale = \"utc\" }"
                                                                               : "";
}

void find_clock(Aid& aid, const Recording& recording, const std::vector<Outage>& withheld, AidedNavigation& out) {
  const std::vector<TimedVelocity> velocities = velocities_of(aid, withheld);
  if (velocities.size() < 10) return;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < velocities.size(); ++i) intervals.push_back(velocities[i].time - velocities[i - 1].time);
  const double interval = median(std::move(intervals)), of_imu = recording.time_s(recording.size() - 1) - recording.time_s(0),
               of_aid = velocities.back().time - velocities.front().time;
  const double length = std::max({finest_interval, interval, recording.interval_s, std::max(of_imu, of_aid) / static_cast<double>(most_bins)});
  if (std::min(of_imu, of_aid) < least_common) return;
  const std::vector<Offset> all =
      offsets(motion_by_imu(recording, length), motion_by_receiver(velocities, interval, length), length, aid.other_scale_s);
  const Offset& highest = *std::ranges::max_element(all, {}, &Offset::likelihood);
  if (highest.likelihood < decisive) return;  // the motion does not determine it
  const Offset best = refined(all, highest, length);
  Offset second;
  for (const Offset& o : all)
    if (std::abs(o.by - best.by) > between_maxima && o.likelihood > second.likelihood) second = o;
  if (second.likelihood > best.likelihood - decisive)
    throw Unsupported(fmt::format(
        "{}: its clock and the recording's have no declared relation, and turns and changes of speed fit with its stamps moved by {:.1f} s{} and by "
        "{:.1f} s{}; declare the scale of the clock (time = {{ scale = \"gps\" }} or \"utc\"), or delay_s and delay_sigma_s in [[aid]]",
        aid.file, best.by, scale_text(best.by, aid.other_scale_s), second.by, scale_text(second.by, aid.other_scale_s)));
  if (std::abs(best.by) <= guessed_offset_sigma) return;
  const double by = aid.other_scale_s > 0 && std::abs(best.by - aid.other_scale_s) <= guessed_offset_sigma ? aid.other_scale_s : best.by;
  for (std::int64_t& stamp : aid.record.time) stamp += std::llround(1e9 * by);
  out.findings.add<Code::stamps_moved>(Subject{aid.file}, by, scale_text(by, aid.other_scale_s));
}

}  // namespace

void find_clocks(std::vector<Aid>& aids, const Recording& recording, const std::vector<Outage>& withheld, AidedNavigation& out) {
  for (Aid& aid : aids)
    if (aid.kind == AidKind::gnss && aid.scale == TimeScale::own && !aid.delay && !aid.delay_sigma && !aid.record.time.empty() &&
        recording.size() > 1)
      find_clock(aid, recording, withheld, out);
}

}  // namespace imulab::aided
