// Rests are found where a recording is quiet compared with the rest of it. In a flight, a drive or a slow turn all of it moves, and its quietest
// stretches are compared with motion alone. What is then left to tell is what a sensor can do: whatever a reading scatters by, its means over a
// second and more follow the laws of noise. They change by N / sqrt(T) with white noise, by B with flicker, and by R T with a drift. The limits here
// are ten times those of poor sensors. Motion exceeds them, since the direction of gravity and the rates of turn change. Vibration does not.
#include "imulab/recording/rest_or_motion.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

namespace imulab {
namespace {

/// The most that readings at rest may change by, as white noise, flicker and drift; and the scatter of one reading that the worst sensors have, as
/// white noise. SI.
struct SensorLimits {
  double N, B, R, usual_N;
  const char* name;
  double unit;
  const char* unit_name;
};
// Poor gyros have N = 0.05 deg/s/sqrt(Hz) and B = 0.01 deg/s; poor accelerometers (of 200 g) 4 mg/sqrt(Hz) and 1 mg. A sensor that warms up drifts
// by degrees an hour.
constexpr SensorLimits gyro_limits{0.25 * unit::deg, 0.05 * unit::deg, 1e-3 * unit::deg, 0.05 * unit::deg, "gyros", unit::deg, "deg/s"};
constexpr SensorLimits accel_limits{0.05, 0.02, 1e-3, 0.02, "accelerometers", 1, "m/s^2"};

constexpr double second_s = 1;
constexpr std::size_t fewest_means = 4;
constexpr double largest_offset = 30 * unit::deg, doubtful_offset = 5 * unit::deg;  // of gyros, which have 20 deg/s in data sheets

std::size_t samples_of_second(const RecordingView& recording) {
  return static_cast<std::size_t>(std::max(1.0, std::round(second_s / recording.interval_s)));
}

/// Means over a second each.
std::vector<double> means_of_seconds(const RecordingView& recording, std::size_t column, const Range& range) {
  const std::size_t block = samples_of_second(recording);
  std::vector<double> means;
  for_each_block(recording, column, range, usual_block / block * block + block, [&](std::span<const double> samples) {
    for (std::size_t at = 0; at + block <= samples.size(); at += block) {
      const std::span<const double> part = samples.subspan(at, block);
      means.push_back(std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(block));
    }
  });
  return means;
}

/// The usual change from one mean to the next, as a standard deviation of one. By the median: a knock or two are no motion.
double usual_change(const std::vector<double>& means) {
  std::vector<double> changes(means.size() - 1);
  for (std::size_t k = 0; k < changes.size(); ++k) changes[k] = std::abs(means[k + 1] - means[k]);
  return median(std::move(changes)) / 0.6745 / std::sqrt(2.0);
}

void halve(std::vector<double>& means) {
  for (std::size_t k = 0; 2 * k + 1 < means.size(); ++k) means[k] = 0.5 * (means[2 * k] + means[2 * k + 1]);
  means.resize(means.size() / 2);
}

/// The first time over which the means of some axis change too much, in words. `scale`: of readings to SI.
std::string excess(const RecordingView& recording, std::size_t first_column, const Range& range, const SensorLimits& limits, double scale) {
  std::array<std::vector<double>, 3> means;
  for (std::size_t axis = 0; axis < 3; ++axis) means[axis] = means_of_seconds(recording, first_column + axis, range);
  const double shortest_s = static_cast<double>(samples_of_second(recording)) * recording.interval_s;
  for (double T = shortest_s; means[0].size() >= fewest_means; T *= 2) {
    const double most = limits.N / std::sqrt(T) + limits.B + limits.R * T / std::sqrt(2.0);
    double change = 0;
    for (std::vector<double>& axis : means) {
      change = std::max(change, scale * usual_change(axis));
      halve(axis);
    }
    if (change > most)
      return fmt::format("means of the {} over {:.2g} s change by {:.2g} {}, those of a sensor at rest by less than {:.2g}", limits.name, T,
                         change / limits.unit, limits.unit_name, most / limits.unit);
  }
  return "";
}

double mean_of_range(const RecordingView& recording, std::size_t column, const Range& range) {
  double sum = 0;
  for_each_block(recording, column, range, usual_block,
                 [&](std::span<const double> samples) { sum = std::accumulate(samples.begin(), samples.end(), sum); });
  return sum / static_cast<double>(range.size());
}

double mean_norm(const RecordingView& recording, std::size_t first_column, const Range& range) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) square += std::pow(mean_of_range(recording, first_column + axis, range), 2);
  return std::sqrt(square);
}

/// The scatter of the readings from one to the next but one [SI], the largest of the axes: a slow change does not count.
double scatter_of(const RecordingView& recording, std::size_t first_column, const Range& range) {
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double square = 0;
    std::size_t count = 0;
    for_each_block(recording, first_column + axis, range, usual_block, [&](std::span<const double> samples) {
      for (std::size_t i = 2; i < samples.size(); ++i) square += std::pow(samples[i] - samples[i - 2], 2);
      count += samples.size() - std::min<std::size_t>(samples.size(), 2);
    });
    if (count > 0) largest = std::max(largest, std::sqrt(0.5 * square / static_cast<double>(count)));
  }
  return largest;
}

}  // namespace

namespace {

/// Of accelerometers' readings to SI; 0 where it is not known. Gravity is far above the scatter: else the mean is something else.
double scale_of(const RecordingView& recording, const Range& range, bool counts_by_gravity) {
  constexpr double far_above = 10;
  const double norm = mean_norm(recording, accel_columns, range);
  if (recording.accel_unit == "m/s^2") return std::min(1.0, unit::g / norm);  // readings far larger than gravity are of another unit
  if (!counts_by_gravity) return 0;
  return norm > far_above * scatter_of(recording, accel_columns, range) ? unit::g / norm : 0;
}

}  // namespace

std::string motion_by_force(const RecordingView& recording, const Range& range, bool counts_by_gravity) {
  if (!recording.has(accel_columns)) return "";
  const double scale = scale_of(recording, range, counts_by_gravity);
  return scale > 0 ? excess(recording, accel_columns, range, accel_limits, scale) : "";
}

std::string motion_in(const RecordingView& recording, const Range& range, bool counts_by_gravity) {
  if (std::string found = motion_by_force(recording, range, counts_by_gravity); !found.empty()) return found;
  if (!recording.has(gyro_columns) || recording.gyro_unit != "rad/s") return "";
  if (const double turn = mean_norm(recording, gyro_columns, range); turn > largest_offset)
    return fmt::format("the gyros read {:.3g} deg/s on average, more than any offset", turn / unit::deg);
  return excess(recording, gyro_columns, range, gyro_limits, 1);
}

std::vector<std::string> doubts_about_rest(const RecordingView& recording, const Range& range) {
  std::vector<std::string> doubts;
  for (const auto& [first_column, limits, si] : {std::tuple(gyro_columns, gyro_limits, recording.gyro_unit == "rad/s"),
                                                 std::tuple(accel_columns, accel_limits, recording.accel_unit == "m/s^2")}) {
    if (!si || !recording.has(first_column)) continue;
    const double scatter = scatter_of(recording, first_column, range), usual = limits.usual_N * std::sqrt(0.5 / recording.interval_s);
    if (scatter > usual)
      doubts.push_back(
          fmt::format("the {} scatter by {:.2g} {} from reading to reading, poor sensors by {:.2g}: the IMU vibrates, or is coarse; the "
                      "noise includes the vibration",
                      limits.name, scatter / limits.unit, limits.unit_name, usual / limits.unit));
  }
  if (!recording.has(gyro_columns) || recording.gyro_unit != "rad/s") return doubts;
  if (const double turn = mean_norm(recording, gyro_columns, range); turn > doubtful_offset)
    doubts.push_back(
        fmt::format("the gyros read {:.3g} deg/s on average: a large offset, or a steady turn about the vertical, whose unevenness the "
                    "noise then includes",
                    turn / unit::deg));
  return doubts;
}

}  // namespace imulab
