#include "imulab/recording/mean_noise.hpp"

#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

/// Forty rests of four seconds in a row at 100 Hz; `of` gives axis and sample.
template <class Reading>
Recording record(Reading of) {
  Recording r;
  r.interval_s = 0.01;
  for (std::size_t i = 0; i < 16000; ++i) r.time_ns.push_back(static_cast<std::int64_t>(i + 1) * 10'000'000);
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 16000; ++i) r.accel[j].push_back(of(j, i)), r.gyro[j].push_back(of(3 + j, i));
  return r;
}

std::vector<RestMeans> rests_of(const Recording& r) {
  std::vector<Range> ranges;
  for (std::size_t k = 0; k < 40; ++k) ranges.push_back({400 * k, 400 * k + 400});
  return summarize_rests(r, ranges);
}

TEST(MeanNoise, WhiteNoiseIsThatOfItsSamples) {
  const RandomStream random(1, "mean noise");
  const Recording r = record([&](std::size_t j, std::size_t i) { return 2 * random.normal(16000 * j + i); });
  const MeanNoise noise = measure_mean_noise(r, rests_of(r));
  // Single samples alone are good to 0.6 %; longer blocks take over once in hundreds of times.
  EXPECT_LT((noise.sample.accel - Vector3d::Constant(2)).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_EQ(noise.rounding.gyro, Vector3d::Zero());
}

TEST(MeanNoise, LowPassedNoiseScattersMoreInTheMeans) {
  // Sums of ten: the variance of a mean is ten times that of as many independent samples.
  const RandomStream random(2, "mean noise");
  const Recording r = record([&](std::size_t j, std::size_t i) {
    double sum = 0;
    for (std::size_t k = 0; k < 10; ++k) sum += random.normal(17000 * j + i + k);
    return sum / std::sqrt(10);
  });
  const MeanNoise noise = measure_mean_noise(r, rests_of(r));
  EXPECT_NEAR(noise.sample.gyro.mean(), std::sqrt(10), 0.2 * std::sqrt(10));
}

TEST(MeanNoise, RoundingDoesNotAverageOut) {
  EXPECT_NEAR(rounding_variance(2, 0), 4.0 / 12, 1e-6);
  EXPECT_LT(rounding_variance(1, 0.5), 1.0 / (400 * 400));
  for (const double sigma : {0.05, 0.2, 0.4}) {
    // The error of a long mean over all places of the true value between two steps.
    double squares = 0;
    for (int place = 0; place < 200; ++place) {
      const double value = (place + 0.5) / 200;
      double mean = 0, sum = 0;
      for (double x = value - 6 * sigma; x < value + 6 * sigma; x += 0.001 * sigma) {
        const double weight = std::exp(-0.5 * std::pow((x - value) / sigma, 2));
        mean += weight * std::round(x), sum += weight;
      }
      squares += std::pow(mean / sum - value, 2) / 200;
    }
    EXPECT_NEAR(rounding_variance(1, sigma), squares, 2e-3 * squares + 1e-7) << sigma;
    const double rounded = std::sqrt(sigma * sigma + 1.0 / 12 - squares);
    EXPECT_NEAR(sigma_before_rounding(1, rounded), sigma, 1e-2 * sigma);
  }
}

/// Rests that all lie between the same two levels scatter as much as noise of half a step would; that a third level is never read tells them apart.
TEST(MeanNoise, NoiseThatIsSmallerThanTheStepIsSeenInRestsBetweenTwoLevels) {
  for (const double sigma : {0.05, 0.1, 0.15, 0.5}) {
    const RandomStream random(4, "mean noise");
    const Recording r = record([&](std::size_t j, std::size_t i) {
      const double value = 0.5 + 0.02 * static_cast<double>(i / 400 % 3);  // steps
      return 0.01 * std::round(value + sigma * random.normal(16000 * j + i));
    });
    const MeanNoise noise = measure_mean_noise(r, rests_of(r));
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double rounding = noise.rounding.gyro[axis], expected = std::sqrt(rounding_variance(0.01, 0.01 * sigma));
      if (sigma < 0.3) {
        EXPECT_GT(rounding, 0.99 * expected) << sigma << " of a step";
        EXPECT_GT(rounding, 0.1 * noise.step.gyro[axis]) << sigma << " of a step";
      } else {
        EXPECT_LT(rounding, 0.01 * noise.step.gyro[axis]) << "no more than a few percent of the noise is missing";
      }
    }
  }
}

TEST(MeanNoise, TheStepIsFoundInTheReadings) {
  const RandomStream random(3, "mean noise");
  const Recording r = record(
      [&](std::size_t j, std::size_t i) { return 0.1 * std::round((0.02 * random.normal(16000 * j + i) + 1e-3 * static_cast<double>(i)) / 0.1); });
  const MeanNoise noise = measure_mean_noise(r, rests_of(r));
  EXPECT_LT((noise.step.accel - Vector3d::Constant(0.1)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(noise.rounding.accel.minCoeff(), 0);
}

}  // namespace
}  // namespace imulab
