#include "imulab/navigation/aided/unmeasured.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;

constexpr std::size_t repeated = 5;  // successive positions: numbers with few digits may repeat by chance

bool has_place(const AidRecord& r, std::size_t row) { return r.position[row].allFinite(); }

/// Removes rows of zeros, which loggers write before the first fix.
std::size_t take_null_rows(AidRecord& r) {
  std::size_t taken = 0;
  for (std::size_t i = 0; i < r.position.size(); ++i) {
    if (!r.position[i].head<2>().isZero(0)) continue;
    r.position[i].setConstant(NAN), ++taken;
    if (!r.velocity.empty() && r.velocity[i].head<2>().isZero(0)) r.velocity[i].setConstant(NAN);
  }
  return taken;
}

/// Number of repeated rows, and of those that a receiver repeated for long while its velocity was not zero: at rest it may keep its position.
struct Repeats {
  std::size_t taken = 0, held = 0;
};
Repeats take_repeats(AidRecord& r) {
  constexpr double lasting = 5, slow = 0.3;  // s: loggers read slower receivers at a rate of their own; m/s
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

/// Fixes that a plausible motion connects.
struct JoinedFixes {
  std::size_t first = 0, last = 0, count = 1;
};

/// Assigns each fix to the latest group from which a motion may lead to it: from old groups, any path is possible.
class FixJoiner {
 public:
  FixJoiner(const Aid& aid, const std::vector<std::size_t>& rows) : aid_(aid) {
    std::vector<double> speeds{0};
    for (std::size_t k = 1; k < rows.size(); ++k)
      speeds.push_back(way_between(aid.record.position[rows[k - 1]], aid.record.position[rows[k]]) / seconds(rows[k - 1], rows[k]));
    usual_ = quantile(std::move(speeds), 0.75);  // jumps are fewer
    for (const std::size_t row : rows) add(row);
  }
  /// Returns the groups, the largest first.
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
    constexpr double sigmas = 6, reflected = 50, fast = 100, usual_times = 3;  // m, as of reflected signals; m/s
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

/// Removes wrong fixes at the start, about which everything is linearized; wrong ones elsewhere become suspects.
void take_lost_begin(Aid& aid, double begin, Subject name, Findings& findings) {
  constexpr double before = 1;     // s: for late stamps
  constexpr std::size_t part = 4;  // with more than one in four, the correct group is uncertain
  AidRecord& r = aid.record;
  const auto time = [&](std::size_t row) { return 1e-9 * static_cast<double>(r.time[row]); };
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < r.position.size(); ++i)
    if (has_place(r, i) && time(i) > begin - before) rows.push_back(i);
  if (rows.empty()) return;
  const std::vector<JoinedFixes> joined = FixJoiner(aid, rows).joined();
  const std::size_t first = joined.front().first;
  if (joined.size() > 1 && part * joined[1].count > rows.size())
    return void(findings.add<Code::positions_not_joined>(name, joined[0].count, time(first), joined[1].count, time(joined[1].first)));
  const auto lost = static_cast<std::size_t>(std::ranges::find(rows, first) - rows.begin());
  if (lost == 0 || part * lost > rows.size()) return;
  const double way = way_between(r.position[first], r.position[rows.front()]);
  for (std::size_t k = 0; k < lost; ++k) r.position[rows[k]].setConstant(NAN);
  findings.add<Code::begin_left_out>(name, lost, rows.size(), time(rows[lost - 1]), way);
}

/// Squared differences between displacements over at least ten seconds and the integrated velocities: as recorded, and with latitude and longitude
/// swapped; and the squared displacements from the velocities.
struct Agreement {
  double plain = 0, swapped = 0, moved = 0;
};
Agreement agreement_of(const AidRecord& r) {
  Agreement out;
  constexpr double span = 10;  // s: the noise of positions is then small compared with the motion
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

/// Warns if the initial state or site of the session is far away.
void judge_place(const AidRecord& r, const Session& session, Subject name, Findings& findings) {
  constexpr double far = 1e6, mean_radius = 6.371e6;  // m
  const std::optional<InitialState>& initial = session.initial;
  const std::optional<double> latitude = initial ? std::optional(initial->latitude) : session.site.latitude;
  const std::optional<double> longitude = initial ? std::optional(initial->longitude) : session.site.longitude;
  if (!latitude) return;
  const auto direction = [](double lat, double lon) { return Vector3d(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)); };
  double nearest = INFINITY;
  for (const Vector3d& place : r.position) {
    const Vector3d here = direction(place.x(), place.y()), there = direction(*latitude, longitude.value_or(place.y()));
    if (place.allFinite()) nearest = std::min(nearest, mean_radius * std::atan2(here.cross(there).norm(), here.dot(there)));
  }
  if (!std::isfinite(nearest) || nearest < far) return;
  findings.add<Code::far_from_site>(name, nearest / 1e3, initial ? "[initial]" : "[site]", *latitude / unit::deg,
                                    longitude ? fmt::format(", longitude {:.6g} deg", *longitude / unit::deg) : "");
}

}  // namespace

void take_unmeasured(std::vector<Aid>& aids, const Session& session, const Recording& recording, AidedNavigation& out) {
  constexpr double few = 1e-3;  // fraction of the samples, as for a bump
  const auto size = static_cast<double>(recording.size()), clipped = static_cast<double>(recording.saturated.size());
  if (clipped > few * size) {
    out.findings.add<Code::samples_at_a_limit>(100 * clipped / size).place = recording.name;
  }
  for (std::size_t k = 0; k < aids.size(); ++k) {
    AidRecord& r = aids[k].record;
    if (aids[k].kind != AidKind::gnss || r.position.empty()) continue;
    const std::string name = aids[k].file.empty() ? fmt::format("aid {} (gnss)", k + 1) : aids[k].file;
    const std::size_t count = r.position.size(), null = take_null_rows(r);
    const auto [repeats, held] = take_repeats(r);
    if (null > 0) out.findings.add<Code::null_positions>(Subject{name}, null, count);
    if (repeats > 0) out.findings.add<Code::held_positions>(Subject{name}, repeats, count);
    if (2 * (null + held) > count) out.findings.add<Code::no_positions>(Subject{name}, null + held, count);
    take_lost_begin(aids[k], session.initial ? session.initial->time : recording.time_s(0), Subject{name}, out.findings);
    judge_place(r, session, Subject{name}, out.findings);
    if (r.velocity.empty()) continue;
    const Agreement a = agreement_of(r);
    if (a.plain > 0.5 * a.moved && a.swapped < 0.02 * a.moved && a.swapped > 0)
      throw Error(name + ": its positions move as its velocities say only with latitude and longitude swapped; expected them swapped");
  }
}

}  // namespace imulab::aided
