#include "imulab/navigation/inertial_samples.hpp"

#include "imulab/navigate.hpp"
#include "imulab/navigation/increment_view.hpp"
#include "imulab/recording/clock.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace imulab {
namespace {

using Eigen::Vector3d;

Vector3d row(const Columns3& columns, std::size_t i) { return {columns[0][i], columns[1][i], columns[2][i]}; }

/// Returns the length of the missing time between samples i - 1 and i.
double missing_before(const Recording& r, std::size_t i) { return r.time_s(i) - r.time_s(i - 1) - r.interval_s; }

/// Returns the number of whole samples missing before sample i, at a gap: the two stamps alone may be late, so the rows up to the next gaps on either
/// side are compared with the clock.
std::size_t rows_before(const Recording& r, std::size_t i, double clock_interval_s) {
  const auto gap = std::lower_bound(r.gaps.begin(), r.gaps.end(), i);
  const std::size_t begin = gap == r.gaps.begin() ? 0 : *std::prev(gap), end = std::next(gap) == r.gaps.end() ? r.size() : *std::next(gap);
  return static_cast<std::size_t>(std::max(0., std::round(clock_step(r.time_ns, i, clock_interval_s, begin, end))));
}

/// Calls `each` for samples that replace those missing before sample i. A rate is extended over the missing time, increments are whole samples.
void bridge(const Recording& r, std::size_t i, std::size_t rows, const std::function<void(const TimedIncrement&, double)>& each) {
  const std::size_t count = std::max<std::size_t>(1, rows);
  const double n = static_cast<double>(count), begin = r.time_s(i - 1), interval = missing_before(r, i) / n;
  const double whole = r.interval_s * static_cast<double>(rows) / n;
  for (std::size_t k = 0; k < count; ++k) {
    const double part = (static_cast<double>(k) + 1) / (n + 1);
    const Vector3d rate = (1 - part) * row(r.gyro, i - 1) + part * row(r.gyro, i);
    const Vector3d force = (1 - part) * row(r.accel, i - 1) + part * row(r.accel, i);
    each({{(r.gyro_increment ? whole : interval) * rate, (r.accel_increment ? whole : interval) * force}, interval},
         begin + interval * (static_cast<double>(k) + 1));
  }
}

/// Returns the increment of a row.
TimedIncrement increment_of(const Recording& r, std::size_t i) {
  const double interval = r.interval(i, false);
  return {{(r.gyro_increment ? r.interval_s : interval) * row(r.gyro, i), (r.accel_increment ? r.interval_s : interval) * row(r.accel, i)}, interval};
}

}  // namespace

std::vector<MissingTime> missing_time(const Recording& r, const Range& range) {
  std::vector<MissingTime> out;
  for (const std::size_t i : r.gaps)
    if (i > range.begin && i < range.end) out.push_back({r.time_s(i - 1), missing_before(r, i)});
  return out;
}

void for_each_increment(const Recording& r, const Range& range, const std::function<void(const TimedIncrement&, double)>& each) {
  const double clock = r.gaps.empty() ? r.interval_s : clock_interval(r.time_ns, r.interval_s);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    if (i > range.begin && r.follows_gap(i)) bridge(r, i, rows_before(r, i, clock), each);
    each(increment_of(r, i), r.time_s(i));
  }
}

IncrementView::IncrementView(const Recording& r) : recording_(&r), size_(r.size()) {
  const double clock = r.gaps.empty() ? r.interval_s : clock_interval(r.time_ns, r.interval_s);
  for (const std::size_t i : r.gaps) {
    if (i == 0) continue;
    Bridge b{.first = i + size_ - r.size(), .row = i, .steps = {}};
    bridge(r, i, rows_before(r, i, clock), [&](const TimedIncrement& step, double) { b.steps.push_back(step); });
    size_ += b.steps.size();
    bridges_.push_back(std::move(b));
  }
}

TimedIncrement IncrementView::operator[](std::size_t i) const {
  const auto after = std::ranges::upper_bound(bridges_, i, {}, &Bridge::first);
  if (after == bridges_.begin()) return increment_of(*recording_, i);
  const Bridge& before = *std::prev(after);
  const std::size_t past = i - before.first;
  return past < before.steps.size() ? before.steps[past] : increment_of(*recording_, before.row + past - before.steps.size());
}

InertialSamples inertial_samples(const Recording& r, const Range& range) {
  InertialSamples out;
  out.gaps = missing_time(r, range);
  out.steps.reserve(range.size());
  out.time.reserve(range.size());
  out.begin = r.time_s(range.begin) - r.interval(range.begin, false);
  for_each_increment(r, range, [&](const TimedIncrement& step, double end) {
    out.steps.push_back(step);
    out.time.push_back(end);
  });
  return out;
}

double stamp_jitter(const Recording& r) {
  double square = 0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < r.size(); ++i) {
    if (r.follows_gap(i)) continue;
    const double off = r.interval(i, false) / r.interval_s - 1;
    square += off * off;
    ++count;
  }
  return count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
}

}  // namespace imulab
