#include "imulab/rig/clock_offset.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace imulab {

namespace {

/// A signal on an even grid of its own.
struct EvenSignal {
  double begin_s = 0, step_s = 0;
  std::vector<double> value;
};

/// The size of the rate, less what a triad reads most of the time.
EvenSignal turning_of(const Recording& r, double step_s) {
  Vector3d usual;
  for (std::size_t k = 0; k < 3; ++k) usual[static_cast<Eigen::Index>(k)] = median(r.gyro[k]);
  EvenSignal out{r.time_s(0) - r.interval_s, step_s, {}};
  const auto cells = static_cast<std::size_t>((r.time_s(r.size() - 1) - out.begin_s) / step_s);
  out.value.assign(cells, 0);
  std::vector<double> count(cells, 0);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const auto cell = static_cast<std::size_t>(std::max(0.0, (r.time_s(i) - 0.5 * r.interval_s - out.begin_s) / step_s));
    if (cell >= cells) continue;
    out.value[cell] += (Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]) - usual).norm();
    ++count[cell];
  }
  for (std::size_t c = 0; c < cells; ++c)
    if (count[c] > 0) out.value[c] /= count[c];
  return out;
}

/// A turn by this angle [rad], or none.
struct Turn {
  double begin_s, end_s, angle;
};

/// Commanded turns, and those between two steps at different angles.
std::vector<Turn> turns_of(std::span<const Step> steps) {
  std::vector<Turn> out;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    if (k > 0) {
      double angle = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        const bool turned = steps[k - 1].kind == StepKind::rotate && static_cast<std::size_t>(steps[k - 1].axis) == a;
        angle += std::abs(step.angles[a] - steps[k - 1].angles[a] - (turned ? steps[k - 1].angle : 0));
      }
      if (angle > 1e-6 && step.start > steps[k - 1].end) out.push_back({steps[k - 1].end, step.start, angle});
    }
    if (step.kind == StepKind::rotate) out.push_back({step.start, step.end, std::abs(step.angle)});
    if (step.kind == StepKind::spin) out.push_back({step.start, step.end, std::abs(step.rate) * (step.end - step.start)});
  }
  return out;
}

/// The same as commanded: a turn's mean rate from its start to its end.
EvenSignal commanded(std::span<const Step> steps, double step_s) {
  EvenSignal out{steps.front().start, step_s, {}};
  out.value.assign(static_cast<std::size_t>(std::max(1.0, (steps.back().end - out.begin_s) / step_s)), 0);
  for (const Turn& turn : turns_of(steps)) {
    if (!(turn.end_s > turn.begin_s)) continue;
    for (std::size_t c = 0; c < out.value.size(); ++c) {
      const double from = out.begin_s + step_s * static_cast<double>(c);
      const double inside = std::min(from + step_s, turn.end_s) - std::max(from, turn.begin_s);
      if (inside > 0) out.value[c] += turn.angle / (turn.end_s - turn.begin_s) * inside / step_s;
    }
  }
  return out;
}

/// Correlation of two signals over their common time where the second is moved by `offset_s`.
double correlation(const EvenSignal& a, const EvenSignal& b, double offset_s) {
  double n = 0, ma = 0, mb = 0, saa = 0, sbb = 0, sab = 0;
  for (std::size_t c = 0; c < b.value.size(); ++c) {
    const double at = (b.begin_s + offset_s - a.begin_s) / a.step_s + static_cast<double>(c);
    const double x = at >= 0 && at + 1 < static_cast<double>(a.value.size()) ? a.value[static_cast<std::size_t>(at)] * (1 - (at - std::floor(at))) +
                                                                                   a.value[static_cast<std::size_t>(at) + 1] * (at - std::floor(at))
                                                                             : 0;  // outside the recording nothing turns
    const double y = b.value[c];
    n += 1, ma += x, mb += y, saa += x * x, sbb += y * y, sab += x * y;
  }
  const double va = saa - ma * ma / n, vb = sbb - mb * mb / n;
  return va > 0 && vb > 0 ? (sab - ma * mb / n) / std::sqrt(va * vb) : 0;
}

/// The best of the offsets from `low` to `high`.
double best_offset(const EvenSignal& a, const EvenSignal& b, double low, double high) {
  double best = low, most = -2;
  for (double offset = low; offset <= high; offset += a.step_s)
    if (const double c = correlation(a, b, offset); c > most) most = c, best = offset;
  return best;
}

/// The middle of a turn as the gyros see it, between the times at which |rate| passes half of its maximum; NaN where they see no such turn.
double middle_in(const Recording& r, const Vector3d& usual, const Turn& turn, double around_s) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const Range range = r.samples_in(turn.begin_s - around_s, turn.end_s + around_s);
  if (range.size() < 8 || r.gaps_in({range.begin + 1, range.end}) > 0) return none;
  std::vector<double> rate;
  for (std::size_t i = range.begin; i < range.end; ++i) rate.push_back((Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]) - usual).norm());
  const double half = 0.5 * *std::max_element(rate.begin(), rate.end());
  const auto above = [half](double value) { return value > half; };
  const auto first = static_cast<std::size_t>(std::find_if(rate.begin(), rate.end(), above) - rate.begin());
  const auto last = rate.size() - 1 - static_cast<std::size_t>(std::find_if(rate.rbegin(), rate.rend(), above) - rate.rbegin());
  // The turn lies inside, and is about as long as commanded.
  if (first == 0 || last + 1 == rate.size()) return none;
  const double rises = static_cast<double>(first) - (rate[first] - half) / (rate[first] - rate[first - 1]),
               falls = static_cast<double>(last) + (rate[last] - half) / (rate[last] - rate[last + 1]);
  const double length = (falls - rises) * r.interval_s, commanded = turn.end_s - turn.begin_s;
  if (length < 0.3 * commanded || length > 1.2 * commanded + 0.1) return none;
  return r.time_s(range.begin) - 0.5 * r.interval_s + 0.5 * (rises + falls) * r.interval_s;
}

}  // namespace

std::optional<ClockRate> clock_rate(const Recording& r, std::span<const Step> steps) {
  constexpr std::size_t fewest = 6;
  constexpr double coarsest = 0.01;  // s: stated times
  Vector3d usual;
  for (std::size_t k = 0; k < 3; ++k) usual[static_cast<Eigen::Index>(k)] = median(r.gyro[k]);
  std::vector<double> at, late;
  for (const Turn& turn : turns_of(steps)) {
    const double middle = 0.5 * (turn.begin_s + turn.end_s);
    const double late_s = middle_in(r, usual, turn, std::max(1.0, 0.25 * (turn.end_s - turn.begin_s))) - middle;
    if (!std::isnan(late_s)) at.push_back(middle), late.push_back(late_s);
  }
  for (;;) {
    if (at.size() < fewest) return std::nullopt;
    const double n = static_cast<double>(at.size());
    const double center = std::accumulate(at.begin(), at.end(), 0.0) / n, mean = std::accumulate(late.begin(), late.end(), 0.0) / n;
    double squares = 0, products = 0;
    for (std::size_t k = 0; k < at.size(); ++k) squares += (at[k] - center) * (at[k] - center), products += (at[k] - center) * (late[k] - mean);
    if (!(squares > 0)) return std::nullopt;
    const double rate = products / squares;
    std::vector<double> residual;
    for (std::size_t k = 0; k < at.size(); ++k) residual.push_back(late[k] - mean - rate * (at[k] - center));
    const double scatter = std::max(robust_sigma(residual), coarsest / 3);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < at.size(); ++k)
      if (std::abs(residual[k]) <= 5 * scatter) at[kept] = at[k], late[kept] = late[k], ++kept;
    if (kept == at.size()) return ClockRate{rate, scatter / std::sqrt(squares), center, mean, kept};
    at.resize(kept), late.resize(kept);
  }
}

std::optional<ClockOffset> clock_offset(const Recording& r, std::span<const Step> steps) {
  if (steps.empty()) return std::nullopt;
  const std::size_t turns = turns_of(steps).size();
  if (turns < 3 || r.size() < 100 || !r.gaps.empty()) return std::nullopt;
  const double length = r.time_s(r.size() - 1) - r.time_s(0), duration = steps.back().end - steps.front().start;
  const double coarse_s = std::max({0.25, length / 1500, duration / 1500}), fine_s = std::max(r.interval_s, coarse_s / 16);
  const EvenSignal rough = turning_of(r, coarse_s), plan = commanded(steps, coarse_s);
  // The log and the recording share at least half of the shorter one.
  const double first = rough.begin_s - plan.begin_s - 0.5 * std::min(length, duration),
               last = rough.begin_s + length - plan.begin_s - 0.5 * std::min(length, duration);
  const double near = best_offset(rough, plan, first, last);
  const EvenSignal sharp = turning_of(r, fine_s), sharp_plan = commanded(steps, fine_s);
  const double at = best_offset(sharp, sharp_plan, near - 2 * coarse_s, near + 2 * coarse_s);
  const double before = correlation(sharp, sharp_plan, at - fine_s), peak = correlation(sharp, sharp_plan, at),
               after = correlation(sharp, sharp_plan, at + fine_s);
  const double curvature = (before - 2 * peak + after) / (fine_s * fine_s);
  if (!(curvature < 0) || !(peak > 0)) return std::nullopt;
  // Of n values with residual variance 1 - peak^2: the correlation falls by peak (offset / sigma)^2 / (2 n) ...
  const double n = static_cast<double>(sharp_plan.value.size());
  const ClockOffset found{at + 0.5 * fine_s * (before - after) / (before - 2 * peak + after), std::sqrt((1 - peak * peak) / (n * peak * -curvature)),
                          peak, correlation(sharp, sharp_plan, 0)};
  // Steps are declared to a tenth of a second; the methods allow for that.
  return std::abs(found.offset_s) > std::max(0.1, 5 * found.sigma_s) ? std::optional(found) : std::nullopt;
}

}  // namespace imulab
