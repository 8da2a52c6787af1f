#include "imulab/recording/mean_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

namespace imulab {

namespace {

/// The rests, and which of them change their temperature: readings then follow a line, and scatter about it.
struct NoiseRests {
  const std::vector<RestMeans>& rests;
  std::vector<char> warming;
};

NoiseRests with_warming(const Recording& recording, const std::vector<RestMeans>& rests) {
  constexpr double least_K = 0.5;
  NoiseRests out{rests, std::vector<char>(rests.size(), 0)};
  const std::vector<double>& temperature = recording.accel_temperature[0].empty() ? recording.gyro_temperature[0] : recording.accel_temperature[0];
  if (temperature.empty()) return out;
  for (std::size_t k = 0; k < rests.size(); ++k) {
    const Range& range = rests[k].range;
    const std::size_t tenth = std::max<std::size_t>(1, range.size() / 10);
    double change = 0;
    for (std::size_t i = 0; i < tenth; ++i) change += temperature[range.end - 1 - i] - temperature[range.begin + i];
    out.warming[k] = std::abs(change) > least_K * static_cast<double>(tenth);
  }
  return out;
}

/// Variance of the means of blocks of a rest about the rest's own mean or line, times the blocks' length, pooled over the rests.
struct BlockVariance {
  double value = 0, degrees = 0;
};

BlockVariance block_variance(const std::vector<double>& column, const NoiseRests& all, std::size_t length) {
  BlockVariance out;
  std::vector<double> means;
  for (std::size_t k = 0; k < all.rests.size(); ++k) {
    const RestMeans& rest = all.rests[k];
    means.clear();
    for (std::size_t begin = rest.range.begin; begin + length <= rest.range.end; begin += length) {
      double sum = 0;
      for (std::size_t i = begin; i < begin + length; ++i) sum += column[i] - column[rest.range.begin];
      means.push_back(sum / static_cast<double>(length));
    }
    const auto n = static_cast<double>(means.size());
    if (n < (all.warming[k] ? 3 : 2)) continue;
    double mean = 0, slope = 0;
    for (const double m : means) mean += m / n;
    for (std::size_t i = 0; all.warming[k] && i < means.size(); ++i)
      slope += 12 * (static_cast<double>(i) - (n - 1) / 2) * means[i] / (n * (n * n - 1));
    for (std::size_t i = 0; i < means.size(); ++i) out.value += std::pow(means[i] - mean - slope * (static_cast<double>(i) - (n - 1) / 2), 2);
    out.degrees += n - (all.warming[k] ? 2 : 1);
  }
  out.value *= static_cast<double>(length) / std::max(out.degrees, 1.0);
  return out;
}

/// By the longest blocks that differ from shorter ones by more than chance: three standard deviations of a variance, 2 / degrees. With fewer than
/// 20 degrees of freedom they would say nothing below a factor of two.
double sample_sigma(const std::vector<double>& column, const NoiseRests& rests) {
  constexpr double least_degrees = 20;
  double variance = block_variance(column, rests, 1).value;
  for (std::size_t length = 2;; length *= 2) {
    const BlockVariance blocks = block_variance(column, rests, length);
    if (blocks.degrees < least_degrees) return std::sqrt(variance);
    if (std::abs(blocks.value - variance) > 3 * std::sqrt(2 / blocks.degrees) * variance) variance = blocks.value;
  }
}

/// The smallest difference between distinct readings if all readings are whole multiples of it apart; else 0.
double rounding_step(const std::vector<double>& column, const RestMeans& longest) {
  // Among hundreds of readings at rest two are equal unless the step is far below the noise, where it does not matter.
  const auto begin = column.begin() + static_cast<std::ptrdiff_t>(longest.range.begin);
  std::vector<double> values(begin, begin + static_cast<std::ptrdiff_t>(std::min<std::size_t>(longest.range.size(), 500)));
  std::sort(values.begin(), values.end());
  if (std::adjacent_find(values.begin(), values.end()) == values.end()) return 0;
  constexpr std::size_t enough = 1'000'000;  // readings, from all of the column
  const std::size_t every = (column.size() + enough - 1) / enough;
  values.clear();
  for (std::size_t i = 0; i < column.size(); i += every) values.push_back(column[i]);
  std::sort(values.begin(), values.end());
  const double rounding = 1e-12 * std::max(std::abs(values.front()), std::abs(values.back()));  // of the numbers themselves
  double step = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double apart = values[i] - values[i - 1]; apart > rounding && (step == 0 || apart < step)) step = apart;
  if (step == 0) return 0;
  // Readings are written with some five digits; a hundredth of a step is more than they lose.
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double steps = (values[i] - values[i - 1]) / step;
    if (std::abs(steps - std::round(steps)) > 0.01 * std::max(1.0, steps)) return 0;
  }
  return step;
}

/// The number of times that each level occurs in a rest, by its distance from the first, in steps.
std::map<std::int64_t, double> levels_of(const std::vector<double>& column, const RestMeans& rest, double step) {
  std::map<std::int64_t, double> counts;
  for (std::size_t i = rest.range.begin; i < rest.range.end; ++i) counts[std::llround((column[i] - column[rest.range.begin]) / step)] += 1;
  return counts;
}

/// Logarithm of the likelihood of these counts for normal noise `sigma` about `mean` before the rounding, both in steps.
double log_likelihood(const std::map<std::int64_t, double>& counts, double mean, double sigma) {
  constexpr double stray = 5e-3;  // of the readings may be anywhere: the last of a motion, at a rest's ends
  double sum = 0;
  for (const auto& [level, count] : counts) {
    const double at = static_cast<double>(level), scale = 1 / (std::numbers::sqrt2 * sigma);
    sum += count * std::log(stray + 0.5 * (std::erf((at + 0.5 - mean) * scale) - std::erf((at - 0.5 - mean) * scale)));
  }
  return sum;
}

/// The log-likelihood of the most likely mean.
double best_log_likelihood(const std::map<std::int64_t, double>& counts, double sigma) {
  constexpr int parts = 20, places = parts + 1;
  double mean = 0, samples = 0;
  for (const auto& [level, count] : counts) mean += static_cast<double>(level) * count, samples += count;
  mean /= samples;
  int best = 0;
  std::array<double, places> at{};  // the mean of rounded readings is less than half a step off
  for (int k = 0; k < places; ++k) {
    at[static_cast<std::size_t>(k)] = log_likelihood(counts, mean + static_cast<double>(k) / parts - 0.5, sigma);
    if (at[static_cast<std::size_t>(k)] > at[static_cast<std::size_t>(best)]) best = k;
  }
  double low = mean + (best - 1.0) / parts - 0.5, high = mean + (best + 1.0) / parts - 0.5;
  for (int k = 0; k < 20; ++k) {  // of three parts the worse outer one goes
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    const bool rising = log_likelihood(counts, a, sigma) < log_likelihood(counts, b, sigma);
    (rising ? low : high) = rising ? a : b;
  }
  return std::max(at[static_cast<std::size_t>(best)], log_likelihood(counts, 0.5 * (low + high), sigma));
}

/// The white noise before the rounding to `step`, by how often each level occurs: its standard deviation alone says nothing where a rest lies between
/// two levels all the time. The least that the readings allow (two standard deviations), since less noise means more error.
double least_sigma(const std::vector<double>& column, const std::vector<RestMeans>& rests, double step) {
  constexpr std::size_t enough = 100;  // rests
  constexpr double finest = 0.05, coarsest = 1.0, ratio = 1.2;
  std::vector<double> likelihood;
  for (double sigma = finest; sigma < coarsest; sigma *= ratio) likelihood.push_back(0);
  for (std::size_t k = 0; k < std::min(rests.size(), enough); ++k) {
    const std::map<std::int64_t, double> counts = levels_of(column, rests[k], step);
    double sigma = finest;
    for (double& sum : likelihood) sum += best_log_likelihood(counts, sigma), sigma *= ratio;
  }
  const double most = *std::max_element(likelihood.begin(), likelihood.end());
  double sigma = finest;
  for (std::size_t k = 0; likelihood[k] < most - 2; ++k) sigma *= ratio;
  return sigma == finest ? 0 : sigma * step;
}

}  // namespace

double rounding_variance(double step, double sigma) {
  if (step == 0) return 0;
  const double pi = std::numbers::pi, ratio = sigma / step;
  double sum = 0, rest = 1.0 / 6 * pi * pi;  // of sum 1 / k^2: what the terms not yet added would be without noise
  for (int k = 1; k <= 1000; ++k) {
    const double term = std::exp(-4 * pi * pi * k * k * ratio * ratio) / (k * k);
    sum += term, rest -= 1.0 / (k * k);
    if (term < 1e-9 * sum) return 0.5 * std::pow(step / pi, 2) * sum;
  }
  return 0.5 * std::pow(step / pi, 2) * (sum + rest);
}

double sigma_before_rounding(double step, double rounded_sigma) {
  // s^2 = sigma^2 + q^2 / 12 - b^2 grows with sigma; no rounded reading scatters less than the noise by more than the step.
  double low = 0, high = rounded_sigma + step;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double variance = middle * middle + step * step / 12 - rounding_variance(step, middle);
    (variance < rounded_sigma * rounded_sigma ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

MeanNoise measure_mean_noise(const Recording& recording, const std::vector<RestMeans>& rests) {
  MeanNoise out;
  if (rests.empty()) return out;
  const auto shorter = [](const RestMeans& a, const RestMeans& b) { return a.range.size() < b.range.size(); };
  const RestMeans& longest = *std::max_element(rests.begin(), rests.end(), shorter);
  const NoiseRests for_blocks = with_warming(recording, rests);
  const SampleNoise single = measure_noise(recording, rests);
  const auto measure = [&](const Columns3& triad, Vector3d SampleNoise::*of) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto axis = static_cast<Eigen::Index>(j);
      const double step = rounding_step(triad[j], longest);
      (out.sample.*of)[axis] = sample_sigma(triad[j], for_blocks);
      (out.step.*of)[axis] = step;
      // Noise of more than a step leaves nothing of it.
      const double noise =
          step > 0 && (single.*of)[axis] < step ? least_sigma(triad[j], rests, step) : sigma_before_rounding(step, (single.*of)[axis]);
      (out.rounding.*of)[axis] = std::sqrt(rounding_variance(step, noise));
    }
  };
  out.sample.accel = out.sample.gyro = out.rounding.accel = out.rounding.gyro = out.step.accel = out.step.gyro = Vector3d::Zero();
  measure(recording.accel, &SampleNoise::accel);
  measure(recording.gyro, &SampleNoise::gyro);
  return out;
}

}  // namespace imulab
