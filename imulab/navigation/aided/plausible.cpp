#include "imulab/navigation/aided/plausible.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;

constexpr std::size_t repeated = 5;  // positions in a row: numbers of few digits may repeat by chance
constexpr double far_level = 4.5;    // sizes of a slow error: a Gaussian one stays below, once in 1e5 values
constexpr double far_constant = 5;   // sigmas of a prior
constexpr double shaking = 50;       // times the declared noise: a car on a road has ten
constexpr double wrong = 20;         // times an aid's usual noise: a receiver between houses has ten
constexpr std::array axis_names{"east", "north", "up"};

bool has_place(const AidRecord& r, std::size_t row) { return r.position[row].allFinite(); }

/// Loggers write zeros before the first fix.
std::size_t take_null_rows(AidRecord& r) {
  std::size_t taken = 0;
  for (std::size_t i = 0; i < r.position.size(); ++i) {
    if (!r.position[i].head<2>().isZero(0)) continue;
    r.position[i].setConstant(NAN), ++taken;
    if (!r.velocity.empty() && r.velocity[i].head<2>().isZero(0)) r.velocity[i].setConstant(NAN);
  }
  return taken;
}

/// Rows that repeat, and those of them that a receiver held for long while it moved, as far as it says: one in a rest may hold its position.
struct Repeats {
  std::size_t taken = 0, held = 0;
};
Repeats take_repeats(AidRecord& r) {
  constexpr double lasting = 5, slow = 0.3;  // s: slower receivers than that are read by loggers at a rate of their own; m/s
  Repeats out;
  for (std::size_t begin = 0, end = 0; begin < r.position.size(); begin = end) {
    for (end = begin + 1; end < r.position.size() && r.position[end] == r.position[begin];) ++end;
    if (end - begin < repeated) continue;
    out.taken += end - begin - 1;
    bool moves = r.velocity.empty();
    for (std::size_t i = begin; i < end && !moves; ++i) moves = !(r.velocity[i].norm() < slow);
    if (moves && 1e-9 * static_cast<double>(r.time[end - 1] - r.time[begin]) > lasting) out.held += end - begin - 1;
    for (std::size_t i = begin + 1; i < end; ++i) r.position[i].setConstant(NAN);
    for (std::size_t i = end; !r.velocity.empty() && --i > begin;)
      if (r.velocity[i] == r.velocity[i - 1] && !r.velocity[i].isZero(0)) r.velocity[i].setConstant(NAN);
  }
  return out;
}

double way_between(const Vector3d& from, const Vector3d& to) { return minus(at_place(to), at_place(from)).segment<3>(At::position).norm(); }

/// Fixes that a motion joins.
struct JoinedFixes {
  std::size_t first = 0, last = 0, count = 1;
};

/// Each fix belongs to the latest of the joined ones that a motion may come from: for old ones any way is possible.
class FixJoiner {
 public:
  FixJoiner(const Aid& aid, const std::vector<std::size_t>& rows) : aid_(aid) {
    std::vector<double> speeds{0};
    for (std::size_t k = 1; k < rows.size(); ++k)
      speeds.push_back(way_between(aid.record.position[rows[k - 1]], aid.record.position[rows[k]]) / seconds(rows[k - 1], rows[k]));
    usual_ = quantile(std::move(speeds), 0.75);  // jumps are fewer
    for (const std::size_t row : rows) add(row);
  }
  /// The most first.
  std::vector<JoinedFixes> joined() {
    std::ranges::stable_sort(all_, std::greater<>(), &JoinedFixes::count);
    return all_;
  }

 private:
  double seconds(std::size_t from, std::size_t to) const { return 1e-9 * static_cast<double>(aid_.record.time[to] - aid_.record.time[from]); }
  double speed(std::size_t row) const {
    const double size = aid_.record.velocity.empty() ? 0 : aid_.record.velocity[row].head<2>().norm();
    return std::isfinite(size) ? size : 0;
  }
  double reach(std::size_t from, std::size_t to) const {
    constexpr double sigmas = 6, reflected = 50, fast = 100, usual_times = 3;  // m: as of reflected signals; m/s
    return reflected + sigmas * (position_sigma(aid_, from).norm() + position_sigma(aid_, to).norm()) +
           (fast + usual_times * usual_ + speed(from) + speed(to)) * seconds(from, to);
  }
  void add(std::size_t row) {
    constexpr std::size_t most_kept = 16;
    JoinedFixes* latest = nullptr;
    for (JoinedFixes& joined : all_)
      if (way_between(aid_.record.position[joined.last], aid_.record.position[row]) < reach(joined.last, row) &&
          (latest == nullptr || joined.last > latest->last))
        latest = &joined;
    if (latest != nullptr) {
      latest->last = row, ++latest->count;
      return;
    }
    if (all_.size() == most_kept) all_.erase(std::ranges::min_element(all_, {}, &JoinedFixes::count));
    all_.push_back({row, row});
  }

  const Aid& aid_;
  double usual_ = 0;  // m/s
  std::vector<JoinedFixes> all_;
};

/// The first fixes are the start, about which all is linear: wrong ones elsewhere are suspects. Text of what was taken, and of a doubt.
struct BeginText {
  std::string taken = {}, doubt = {};
};
BeginText take_lost_begin(Aid& aid, double begin) {
  constexpr double before = 1;     // s: of late stamps
  constexpr std::size_t part = 4;  // more than one in four is a matter of opinion
  AidRecord& r = aid.record;
  const auto time = [&](std::size_t row) { return 1e-9 * static_cast<double>(r.time[row]); };
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < r.position.size(); ++i)
    if (has_place(r, i) && time(i) > begin - before) rows.push_back(i);
  if (rows.empty()) return {};
  const std::vector<JoinedFixes> joined = FixJoiner(aid, rows).joined();
  const std::size_t first = joined.front().first;
  if (joined.size() > 1 && part * joined[1].count > rows.size())
    return {.doubt = fmt::format("no motion joins {} of its positions, from {:.6g} s on, and {} from {:.6g} s on: which are right is not known",
                                 joined[0].count, time(first), joined[1].count, time(joined[1].first))};
  const auto lost = static_cast<std::size_t>(std::ranges::find(rows, first) - rows.begin());
  if (lost == 0 || part * lost > rows.size()) return {};
  const double way = way_between(r.position[first], r.position[rows.front()]);
  for (std::size_t k = 0; k < lost; ++k) r.position[rows[k]].setConstant(NAN);
  return {.taken = fmt::format("{} of {} positions, until {:.6g} s, are left out: {:.3g} m from where the others begin, which no motion explains",
                               lost, rows.size(), time(rows[lost - 1]), way)};
}

/// Squares of displacements over ten seconds and more less those that the velocities give: as they stand, with latitude and longitude swapped, and of
/// the displacements by the velocities.
struct Agreement {
  double plain = 0, swapped = 0, moved = 0;
};
Agreement agreement_of(const AidRecord& r) {
  Agreement out;
  constexpr double span = 10;  // s: then the noise of positions is small against the motion
  std::size_t from = 0;
  Vector3d moved = Vector3d::Zero();
  for (std::size_t i = 1; i < r.time.size(); ++i) {
    const double dt = 1e-9 * static_cast<double>(r.time[i] - r.time[i - 1]);
    moved += dt / 2 * (r.velocity[i] + r.velocity[i - 1]);
    if (!has_place(r, i) || !has_place(r, from) || !moved.head<2>().allFinite() || dt > 5) {
      from = i, moved.setZero();
      continue;
    }
    if (1e-9 * static_cast<double>(r.time[i] - r.time[from]) < span) continue;
    const auto displaced = [&](int latitude, int longitude) {
      const LocalEarth earth = local_earth(r.position[from][latitude], r.position[from].z());
      const Vector3d by = r.position[i] - r.position[from];
      return Eigen::Vector2d(by[longitude] * earth.transverse_radius * earth.cos_latitude, by[latitude] * earth.meridian_radius);
    };
    out.plain += (displaced(0, 1) - moved.head<2>()).squaredNorm(), out.moved += moved.head<2>().squaredNorm();
    if (std::abs(r.position[from].y()) < 1.55) out.swapped += (displaced(1, 0) - moved.head<2>()).squaredNorm();
    from = i, moved.setZero();
  }
  return out;
}

/// Where the session's initial state or site is nowhere near.
std::string far_from_declared(const AidRecord& r, const Session& session) {
  constexpr double far = 1e6, mean_radius = 6.371e6;  // m
  const std::optional<InitialState>& initial = session.initial;
  const std::optional<double> latitude = initial ? std::optional(initial->latitude) : session.site.latitude;
  const std::optional<double> longitude = initial ? std::optional(initial->longitude) : session.site.longitude;
  if (!latitude) return "";
  const auto direction = [](double lat, double lon) { return Vector3d(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)); };
  double nearest = INFINITY;
  for (const Vector3d& place : r.position) {
    const Vector3d here = direction(place.x(), place.y()), there = direction(*latitude, longitude.value_or(place.y()));
    if (place.allFinite()) nearest = std::min(nearest, mean_radius * std::atan2(here.cross(there).norm(), here.dot(there)));
  }
  if (!std::isfinite(nearest) || nearest < far) return "";
  return fmt::format("its positions are {:.0f} km and more from {}, latitude {:.6g} deg{}; expected one of them corrected", nearest / 1e3,
                     initial ? "[initial]" : "[site]", *latitude / unit::deg,
                     longitude ? fmt::format(", longitude {:.6g} deg", *longitude / unit::deg) : "");
}

std::string place_of(const Channel& c) { return c.aid.file.empty() ? c.name : fmt::format("{} ({})", c.name, c.aid.file); }

}  // namespace

void take_unmeasured(std::vector<Aid>& aids, const Session& session, const Recording& recording, AidedNavigation& out) {
  for (std::size_t k = 0; k < aids.size(); ++k) {
    AidRecord& r = aids[k].record;
    if (aids[k].kind != AidKind::gnss || r.position.empty()) continue;
    const std::string name = aids[k].file.empty() ? fmt::format("aid {} (gnss)", k + 1) : aids[k].file;
    const auto warn = [&](const std::string& text) {
      if (!text.empty()) out.warnings.push_back(name + ": " + text);
    };
    const auto doubt = [&](const std::string& text) { warn(text), out.doubts.push_back(name + ": " + text); };
    const std::size_t count = r.position.size(), null = take_null_rows(r);
    const auto [repeats, held] = take_repeats(r);
    if (null > 0) warn(fmt::format("{} of {} positions are at latitude 0 and longitude 0: no fixes, and they are left out", null, count));
    if (repeats > 0)
      warn(fmt::format("{} of {} positions repeat the one before exactly: the receiver holds its last one, and they are left out", repeats, count));
    if (2 * (null + held) > count)
      doubt(fmt::format("{} of {} positions are zeros, or held while it moves: the aid hardly measures the position", null + held, count));
    const BeginText begin = take_lost_begin(aids[k], session.initial ? session.initial->time : recording.time_s(0));
    warn(begin.taken);
    for (const std::string& text : {begin.doubt, far_from_declared(r, session)})
      if (!text.empty()) doubt(text);
    if (r.velocity.empty()) continue;
    const Agreement a = agreement_of(r);
    if (a.plain > 0.5 * a.moved && a.swapped < 0.02 * a.moved && a.swapped > 0)
      throw Error(name + ": its positions move as its velocities say only with latitude and longitude swapped; expected them swapped");
  }
}

std::vector<std::string> runs_of_suspects(const AidedNavigation& n) {
  struct Run {
    double begin = 0, end = -INFINITY, last = -INFINITY;  // of suspects; the last value
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
  std::vector<std::string> out;
  for (std::size_t k = 0; k < longest.size(); ++k)
    if (const Run& run = longest[k]; run.values >= many)
      out.push_back(fmt::format("the values of {} from {:.6g} s to {:.6g} s contradict all else: suspects, which hardly count", n.factors[k].name,
                                run.begin, run.end));
  return out;
}

namespace {

/// The change of a slow error within some seconds that its law forbids most, in sigmas of that.
struct LevelStep {
  double time = 0, change = 0, sigmas = 0;
};
LevelStep largest_step(const std::vector<double>& times, const std::function<double(std::size_t)>& level, double size, double time_constant) {
  constexpr double soon = 3;  // s: the smoothed level changes so quickly where it jumps
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

/// What the law of a slow error forbids of its level; empty: nothing. `size`: its stationary sigma.
std::string contradiction_of(const Channel& c, const std::vector<double>& times, const std::function<double(std::size_t)>& level, double size,
                             double time_constant, Index axis) {
  std::size_t worst = 0;
  for (std::size_t k = 1; k < times.size(); ++k)
    if (std::abs(level(k)) > std::abs(level(worst))) worst = k;
  const LevelStep step = largest_step(times, level, size, time_constant);
  const bool far = std::abs(level(worst)) > far_level * size;
  if (!far && !(step.sigmas > far_level)) return "";
  const double by = far ? level(worst) : step.change;
  return fmt::format(
      "{}: its {} {} at {:.6g} s by the other data, {:.2g} times what its slow error lets expect: ", place_of(c),
      c.aid.kind == AidKind::gnss ? fmt::format("positions are {:.3g} m {}", std::abs(by), axis_names[static_cast<std::size_t>(axis)]) : "values are",
      far ? "off" : "more than before", far ? times[worst] : step.time, far ? std::abs(by) / size : step.sigmas);
}

}  // namespace

void widen_by_levels(const Problem& p, const std::vector<double>& times, const SmootherPass& smoothed, AidedNavigation& out) {
  for (const Channel& c : p.channels) {
    if (c.slow < 0 || !has_record(c.aid.kind)) continue;
    const StateBlock& slow = *std::ranges::find(p.blocks, c.slow, &StateBlock::first);
    const double size = slow.sigma * std::sqrt(p.sources[*slow.noise].factor);
    for (Index axis = 0; axis < slow.size; ++axis) {
      const auto level = [&](std::size_t k) { return smoothed.nodes[k].state.x[c.slow + axis]; };
      const std::string contradiction = contradiction_of(c, times, level, size, slow.time, axis);
      if (contradiction.empty()) continue;
      const bool places = c.aid.kind == AidKind::gnss;
      out.doubts.push_back(contradiction +
                           (places ? "another datum or geoid, a jump, or aids that contradict each other; the sigmas of the position contain it"
                                   : "another zero, unit or sign, or aids that contradict each other"));
      out.warnings.push_back(out.doubts.back());
      if (!places) continue;
      // It lasts as the slow error does: a jump passes through zero.
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

/// Records have the same positions: one receiver, whose errors count once.
bool same_positions(const AidRecord& a, const AidRecord& b) {
  constexpr double equal = 1e-10;  // rad: less than a millimeter
  std::size_t common = 0, same = 0;
  for (std::size_t i = 0, j = 0; i < a.position.size() && j < b.position.size(); ++i) {
    while (j < b.position.size() && b.time[j] < a.time[i]) ++j;
    if (j == b.position.size() || b.time[j] != a.time[i] || !(a.position[i] - b.position[j]).allFinite()) continue;
    ++common, same += (a.position[i] - b.position[j]).head<2>().cwiseAbs().maxCoeff() < equal;
  }
  return common >= repeated && 2 * same > common;
}

/// How many times its usual size the noise of an aid is, the largest of its sources.
double times_usual(const Problem& p, const Channel& c) {
  const AidRecord& r = c.aid.record;
  const AidLaw& law = aid_law(c.aid.kind);
  const auto times = [&](const auto& values, double usual, std::size_t source, const auto& sigma) {
    std::vector<double> all;
    for (std::size_t i = 0; i < values.size(); ++i) all.push_back(sigma(c.aid, i));
    return all.empty() ? 0 : median(std::move(all)) * std::sqrt(p.sources[source].factor) / usual;
  };
  return std::max({times(r.position, law.position_sigma, c.first_noise, [](const Aid& aid, std::size_t i) { return position_sigma(aid, i).mean(); }),
                   times(r.velocity, law.velocity_sigma, c.second_noise, [](const Aid& aid, std::size_t i) { return velocity_sigma(aid, i).mean(); }),
                   times(r.value, law.value_sigma, c.first_noise, value_sigma)});
}

}  // namespace

std::vector<std::string> implausible_estimates(const Problem& p, const SmoothedNode& last, const AidedNavigation& out) {
  std::vector<std::string> doubts;
  if (std::ranges::none_of(p.observations, [&](const Observation& o) { return !o.withheld && has_record(p.channels[o.channel].aid.kind); }))
    doubts.emplace_back(std::ranges::any_of(p.observations, &Observation::withheld)
                            ? "all values of the aids are withheld: nothing corrects the solution"
                            : "no aid measures the position; expected an [[aid]] of kind = \"gnss\" with its file");
  const Prior prior = prior_of(p);
  for (const Channel& c : p.channels) {
    for (const Channel& before : p.channels)
      if (&before < &c && same_positions(before.aid.record, c.aid.record))
        doubts.push_back(
            fmt::format("{}: has the positions of {}: one receiver, whose errors count once; leave one out", place_of(c), place_of(before)));
    if (const double times = times_usual(p, c); times > wrong)
      doubts.push_back(fmt::format("{}: its noise comes out {:.3g} times what a {} usually has: another unit, sign or frame", place_of(c), times,
                                   aid_law(c.aid.kind).name));
    for (const StateBlock& b : p.blocks) {
      const bool own = (c.lever >= 0 && b.first == c.lever) || (c.delay >= 0 && b.first == c.delay);
      for (Index k = b.first; own && k < b.first + b.size; ++k) {
        // What data that agree with a prior add to it has the variance by which they reduce it.
        constexpr double learned = 0.05;  // of the variance: less is rounding
        const double off = std::abs(last.state.x[k] - prior.mean[k]), declared = b.prior[k - b.first] * b.prior[k - b.first];
        const double added = declared - last.variance[k];
        if (added > learned * declared && off > far_constant * std::sqrt(added))
          doubts.push_back(fmt::format("{}: comes out {:.3g} from what is declared, {:.3g} times what its sigma lets expect", in_words(b.name), off,
                                       off / std::sqrt(added)));
      }
    }
  }
  for (const std::size_t source : {p.gyro_source, p.accel_source})
    if (const double times = std::sqrt(out.factors[source].factor); times > shaking)
      doubts.push_back(
          fmt::format("the noise of the {} comes out {:.3g} times its declared size: the recording in other axes or units, or positions that jump",
                      source == p.gyro_source ? "gyros" : "accelerometers", times));
  return doubts;
}

}  // namespace imulab::aided
