#include "imulab/rig/clock_offset.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/eigen.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

namespace imulab {

namespace {

/// A signal on an even grid of its own.
struct EvenSignal {
  double begin_s = 0, step_s = 0;
  std::vector<double> value;
};

/// The usual reading of a triad.
Vector3d usual_rate(const Recording& r) {
  constexpr std::size_t enough = 1'000'000;  // samples, from all of the recording
  const std::size_t every = r.size() / enough + 1;
  Vector3d usual;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> samples;
    for (std::size_t i = 0; i < r.size(); i += every) samples.push_back(r.gyro[k][i]);
    usual[static_cast<Eigen::Index>(k)] = median(std::move(samples));
  }
  return usual;
}

/// The size of the rate, less what a triad reads most of the time.
EvenSignal turning_of(const Recording& r, double step_s) {
  const Vector3d usual = usual_rate(r);
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

/// The commanded rate: a turn's mean rate from its start to its end.
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

/// The delays of a turn's begin and end in the data, where |rate| passes half of its maximum.
struct Late {
  double begin_s, end_s;
};

/// Empty where the gyros see no such turn.
std::optional<Late> late_in(const Recording& r, const Vector3d& usual, const Step& turn) {
  const double commanded = turn.end - turn.start, around_s = std::clamp(0.25 * commanded, 1.0, 5.0);
  const Range range = r.samples_in(turn.start - around_s, turn.end + around_s);
  if (range.size() < 8 || r.gaps_in({range.begin + 1, range.end}) > 0) return std::nullopt;
  std::vector<double> rate;
  for (std::size_t i = range.begin; i < range.end; ++i) rate.push_back((Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]) - usual).norm());
  const double half = 0.5 * *std::max_element(rate.begin(), rate.end());
  if (!(half > 0) || rate.front() > half || rate.back() > half) return std::nullopt;
  std::size_t first = 1, last = rate.size() - 2;
  while (!(rate[first] > half)) ++first;
  while (!(rate[last] > half)) --last;
  const double rises = static_cast<double>(first) - (rate[first] - half) / (rate[first] - rate[first - 1]),
               falls = static_cast<double>(last) + (rate[last] - half) / (rate[last] - rate[last + 1]);
  const double length = (falls - rises) * r.interval_s, begin = r.time_s(range.begin) - 0.5 * r.interval_s;
  if (length < 0.4 * commanded || length > 1.05 * commanded + 0.1) return std::nullopt;  // of a turn that never reaches its rate it is half
  return Late{begin + rises * r.interval_s - turn.start, begin + falls * r.interval_s - turn.end};
}

/// The line through values at times, and its slope's standard deviation if they scatter by `scatter`.
struct FittedLine {
  double at, value, slope, slope_sigma;
};
FittedLine line_through(const std::vector<double>& at, const std::vector<double>& value, double scatter) {
  const double n = static_cast<double>(at.size());
  FittedLine line{std::accumulate(at.begin(), at.end(), 0.0) / n, std::accumulate(value.begin(), value.end(), 0.0) / n, 0, 0};
  double squares = 0, products = 0;
  for (std::size_t k = 0; k < at.size(); ++k) squares += std::pow(at[k] - line.at, 2), products += (at[k] - line.at) * (value[k] - line.value);
  line.slope = products / squares, line.slope_sigma = scatter / std::sqrt(squares);
  return line;
}

/// The largest step down of values besides a line, where chance does not explain it. Their scatter is that of neighbors, of which few have the step.
double step_down(const std::vector<double>& at, const std::vector<double>& value, double least_scatter) {
  constexpr std::size_t aside = 2;  // turns before and after it, at least: one may be mistaken
  constexpr double clear = 6;       // sigmas, of the best of many places, with a scatter that few turns show
  std::vector<double> change, slope;
  for (std::size_t k = 1; k < at.size(); ++k) slope.push_back((value[k] - value[k - 1]) / (at[k] - at[k - 1]));
  const double usual = median(slope);
  for (std::size_t k = 1; k < at.size(); ++k) change.push_back(value[k] - value[k - 1] - usual * (at[k] - at[k - 1]));
  const double scatter = std::max(robust_sigma(change) / std::sqrt(2.), least_scatter);
  double down = 0;
  for (std::size_t split = aside; split + aside <= at.size(); ++split) {
    std::vector<double> after(at.size(), 0);
    std::fill(after.begin() + static_cast<std::ptrdiff_t>(split), after.end(), 1);
    const FittedLine line = line_through(at, after, 0);
    double squares = 0, products = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      const double beside = after[k] - line.value - line.slope * (at[k] - line.at);
      squares += beside * beside, products += beside * value[k];
    }
    const double step = products / squares;
    if (-step > clear * scatter / std::sqrt(squares)) down = std::max(down, -step);
  }
  return down;
}

}  // namespace

std::optional<ClockRate> clock_rate(const Recording& r, std::span<const Step> steps) {
  constexpr std::size_t fewest = 6;
  constexpr double least_scatter = 0.003;  // s: of times stated to a hundredth
  std::vector<Step> turns;
  std::copy_if(steps.begin(), steps.end(), std::back_inserter(turns), [](const Step& step) { return step.kind == StepKind::rotate; });
  if (turns.size() < fewest) return std::nullopt;
  const Vector3d usual = usual_rate(r);
  std::vector<double> at, begins, ends;
  for (const Step& turn : turns)
    if (const std::optional<Late> late = late_in(r, usual, turn))
      at.push_back(0.5 * (turn.start + turn.end)), begins.push_back(late->begin_s), ends.push_back(late->end_s);
  const auto middles_of = [&] {
    std::vector<double> out;
    for (std::size_t k = 0; k < at.size(); ++k) out.push_back(0.5 * (begins[k] + ends[k]));
    return out;
  };
  const double lost_s = at.size() >= fewest ? step_down(at, middles_of(), least_scatter) : 0;
  while (at.size() >= fewest && at.front() < at.back()) {
    const std::vector<double> middles = middles_of();
    std::vector<double> residual;
    const FittedLine rough = line_through(at, middles, 0);
    for (std::size_t k = 0; k < at.size(); ++k) residual.push_back(middles[k] - rough.value - rough.slope * (at[k] - rough.at));
    const double scatter = std::max(robust_sigma(residual), least_scatter);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < at.size(); ++k)
      if (std::abs(residual[k]) <= 5 * scatter) at[kept] = at[k], begins[kept] = begins[k], ends[kept] = ends[k], ++kept;
    if (kept == at.size()) {
      // A clock moves both ends of a turn; a table that takes longer and longer to come to rest, only one.
      const FittedLine line = line_through(at, middles, scatter), by_begins = line_through(at, begins, scatter),
                       by_ends = line_through(at, ends, scatter);
      if (std::abs(by_begins.slope - by_ends.slope) > std::max(0.5 * std::abs(line.slope), 5 * line.slope_sigma)) return std::nullopt;
      return ClockRate{line.slope, line.slope_sigma, line.at, line.value, kept, lost_s};
    }
    at.resize(kept), begins.resize(kept), ends.resize(kept);
  }
  return std::nullopt;
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
  // For n values with residual variance 1 - peak^2 the correlation falls by peak (offset / sigma)^2 / (2 n) ...
  const double n = static_cast<double>(sharp_plan.value.size());
  const ClockOffset found{at + 0.5 * fine_s * (before - after) / (before - 2 * peak + after), std::sqrt((1 - peak * peak) / (n * peak * -curvature)),
                          peak, correlation(sharp, sharp_plan, 0)};
  // Steps are declared to a tenth of a second; the methods allow for that.
  return std::abs(found.offset_s) > std::max(0.1, 5 * found.sigma_s) ? std::optional(found) : std::nullopt;
}

}  // namespace imulab
