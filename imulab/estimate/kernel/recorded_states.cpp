#include "imulab/estimate/kernel/recorded_states.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace imulab::kernel {

namespace {

std::optional<TemperatureSweep> sweep_of(const Recording& r, const std::optional<Thermometer>& thermometer) {
  constexpr double least_K = 10, ends = 0.005, beyond = 0.1;  // a thermometer may have outliers
  constexpr std::size_t most = 65536;
  if (!thermometer) return {};
  const std::vector<double>& readings = *thermometer->readings;
  std::vector<double> some;
  for (std::size_t i = 0; i < readings.size(); i += readings.size() / most + 1) some.push_back(readings[i]);
  const double low = quantile(some, ends), high = quantile(some, 1 - ends);
  if (!(high - low >= least_K * std::abs(thermometer->per_K))) return {};
  const auto is_that_of = [&](const Columns3& triad) {
    return std::ranges::all_of(triad, [&](const std::vector<double>& column) { return column == readings; });
  };
  TemperatureSweep out{.per_K = thermometer->per_K, .accel = is_that_of(r.accel_temperature), .gyro = is_that_of(r.gyro_temperature)};
  const auto [least, greatest] = std::ranges::minmax(readings);
  const double more = beyond * (high - low);
  out.reading = {thermometer->unit, thermometer->mean, {std::max(least, low - more), std::min(greatest, high + more)}};
  return out;
}

/// Consecutive equal means of a thermometer.
struct Level {
  std::size_t begin, end;
  double value;
};

/// A temperature at a place between means.
struct Knot {
  double at, value;
};

/// The value at a place on the line through two knots, within half a step of the level.
Knot on_line(const Knot& a, const Knot& b, double at, double level, double half_step) {
  return {at, std::clamp(a.value + (b.value - a.value) * (at - a.at) / (b.at - a.at), level - half_step, level + half_step)};
}

/// Where a level passes to the next one, at once or within one mean: half way between them. Nothing if other readings lie between.
std::optional<Knot> passage(std::span<const double> means, const Level& a, const Level& b) {
  if (b.begin > a.end + 1) return {};
  const double part = b.begin == a.end ? 0 : (b.value - means[a.end]) / (b.value - a.value);
  return Knot{static_cast<double>(a.end) + std::clamp(part, 0.0, 1.0), 0.5 * (a.value + b.value)};
}

/// Replaces the means of a coarse thermometer, which are equal for some time, by lines between its passages from level to level.
void join_levels(std::span<double> means) {
  std::vector<Level> levels;
  for (std::size_t k = 0; k < means.size(); ++k)
    if (!levels.empty() && levels.back().end == k && levels.back().value == means[k])
      levels.back().end = k + 1;
    else
      levels.push_back({k, k + 1, means[k]});
  std::erase_if(levels, [](const Level& level) { return level.end - level.begin < 2; });
  for (std::size_t first = 0, last = 0; first < levels.size(); first = ++last) {
    std::vector<Knot> knots;
    for (; last + 1 < levels.size(); ++last)
      if (const auto knot = passage(means, levels[last], levels[last + 1]))
        knots.push_back(*knot);
      else
        break;
    if (knots.size() < 2) continue;
    const auto half_step = [&](std::size_t k) { return 0.5 * std::abs(levels[k + 1].value - levels[k].value); };
    const Knot begin = on_line(knots[0], knots[1], static_cast<double>(levels[first].begin), levels[first].value, half_step(first));
    const Knot end = on_line(knots.back(), knots[knots.size() - 2], static_cast<double>(levels[last].end), levels[last].value, half_step(last - 1));
    knots.insert(knots.begin(), begin), knots.push_back(end);
    std::size_t k = 0;
    for (std::size_t i = levels[first].begin; i < levels[last].end; ++i) {
      const double at = static_cast<double>(i) + 0.5;
      while (k + 2 < knots.size() && knots[k + 1].at < at) ++k;
      means[i] = knots[k].value + (knots[k + 1].value - knots[k].value) * (at - knots[k].at) / (knots[k + 1].at - knots[k].at);
    }
  }
}

}  // namespace

RecordedStates::RecordedStates(const Recording& recording, const Session& session, const SensorModel& model, const Scaling& scaling)
    : recording_(&recording), thermometer_(thermometer_of(recording, session.source_of(recording.name))), sweep_(sweep_of(recording, thermometer_)) {
  constexpr double block_s = 5;  // thermometers are noisy or coarse
  if (sweep_) {
    block_ = std::max<std::size_t>(1, static_cast<std::size_t>(block_s / recording.interval_s));
    std::vector<std::size_t> starts = recording.starts;
    starts.insert(starts.begin(), 0), starts.push_back(recording.size());
    for (std::size_t r = 0; r + 1 < starts.size(); ++r) {
      blocks_.push_back({starts[r], warming_.size(), 0});
      for (std::size_t begin = starts[r]; begin + block_ <= starts[r + 1]; begin += block_, ++blocks_.back().size) {
        double sum = 0;
        for (std::size_t i = begin; i < begin + block_; ++i) sum += thermometer_->warming(i);
        warming_.push_back(sum / static_cast<double>(block_));
      }
      join_levels(std::span(warming_).subspan(blocks_.back().first, blocks_.back().size));
    }
    const auto blocks = static_cast<std::size_t>(thermometer_lag_s / block_s);
    double most = 0;
    for (const Blocks& own : blocks_)
      for (std::size_t j = own.first + blocks; j < own.first + own.size; ++j) most = std::max(most, std::abs(warming_[j] - warming_[j - blocks]));
    sweep_->range_K = (sweep_->reading.range[1] - sweep_->reading.range[0]) / std::abs(sweep_->per_K);
    sweep_->shortest_s = most > 0 ? sweep_->range_K / most * thermometer_lag_s : HUGE_VAL;
  }
  common_.gravity = session.site.gravity();
  common_.full_force = common_.gravity;
  common_.full_rate = 1;  // rad/s: no gyro has a smaller range, and slower turns do not excite higher-order terms
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const Vector3d force = linear_output(model.accel, scaling.accel(reading_at(recording.accel, i)));
    const Vector3d rate = linear_output(model.gyro, scaling.gyro(reading_at(recording.gyro, i)));
    common_.full_force = std::max(common_.full_force, force.cwiseAbs().maxCoeff());
    common_.full_rate = std::max(common_.full_rate, rate.cwiseAbs().maxCoeff());
  }
}

int RecordedStates::recording_of(std::size_t sample) const {
  const std::vector<std::size_t>& starts = recording_->starts;
  return static_cast<int>(std::upper_bound(starts.begin(), starts.end(), sample) - starts.begin());
}

void RecordedStates::set_warming(std::size_t sample, EffectState& state) const {
  const Blocks& own = blocks_[static_cast<std::size_t>(recording_of(sample))];
  state.warming = thermometer_->warming(sample), state.warming_rate = 0;
  if (own.size < 3) return;
  const double* const means = &warming_[own.first];
  const double place = static_cast<double>(sample - own.first_sample) / static_cast<double>(block_) - 0.5;
  const double inside = std::clamp(place, 0.0, static_cast<double>(own.size - 1));
  const std::size_t before = std::min(static_cast<std::size_t>(inside), own.size - 2);
  state.warming = std::lerp(means[before], means[before + 1], inside - static_cast<double>(before));
  const std::size_t middle = std::clamp<std::size_t>((sample - own.first_sample) / block_, 1, own.size - 2);
  state.warming_rate = (means[middle + 1] - means[middle - 1]) / (2 * static_cast<double>(block_) * recording_->interval_s);
}

EffectState RecordedStates::over(const Range& range) const {
  constexpr std::size_t places = 16;
  EffectState state = at(range.begin + range.size() / 2);
  if (!sweep_) return state;
  EffectState there;
  double warming = 0, rate = 0;
  for (std::size_t k = 0; k < places; ++k) {
    set_warming(range.begin + (2 * k + 1) * range.size() / (2 * places), there);
    warming += *there.warming / places, rate += there.warming_rate / places;
  }
  state.warming = warming, state.warming_rate = rate;
  return state;
}

EffectState RecordedStates::at(std::size_t sample) const {
  EffectState state = common_;
  const std::vector<std::size_t>& starts = recording_->starts;
  state.recording = recording_of(sample);
  const auto after = starts.begin() + state.recording;
  const double begin = recording_->time_s(after == starts.begin() ? 0 : *(after - 1));
  const double end = recording_->time_s((after == starts.end() ? recording_->size() : *after) - 1);
  state.time = (recording_->time_s(sample) - begin) / std::max(end - begin, 1e-9) - 0.5;
  if (sweep_)
    set_warming(sample, state);
  else if (thermometer_)
    state.warming = thermometer_->warming(sample);
  return state;
}

}  // namespace imulab::kernel
