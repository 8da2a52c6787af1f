#include "imulab/noise/bound.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise.hpp"

#include <gtest/gtest.h>

#include "tests/flicker_log.hpp"
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

constexpr double interval = 0.01, horizon = 600;

std::vector<UpperDensity> spectrum(const std::vector<double>& hz, const auto& density) {
  std::vector<UpperDensity> out;
  for (const double f : hz) out.push_back({f, density(f)});
  return out;
}

/// White noise of N = 1 at rest, as readings.
std::vector<double> white_log(std::size_t samples, std::uint64_t seed) {
  std::vector<double> rate(samples);
  const RandomStream draws(seed, "white noise of a bound");
  for (std::size_t i = 0; i < samples; ++i) rate[i] = draws.normal(i) / std::sqrt(interval);
  return rate;
}

TEST(NoiseBound, WhiteNoiseWithWalkIsItsOwn) {
  const auto walk = [](double f) { return std::pow(interval / (2 * std::sin(std::numbers::pi * f * interval)), 2); };
  const NoiseBound bound = noise::tightest_bound(spectrum(noise::bound_frequencies(interval, horizon), [&](double f) { return 4 + 0.01 * walk(f); }),
                                                 interval, {.horizon_s = horizon});
  EXPECT_NEAR(bound.N, 2, 1e-9);
  EXPECT_NEAR(bound.K, 0.1, 1e-9);
  EXPECT_TRUE(bound.markov.empty());
  EXPECT_NEAR(bound.tightness, 1, 1e-9);
}

TEST(NoiseBound, IsNowhereBelowFlickerAndClose) {
  const auto flicker = [](double f) { return 1 + 0.05 / (2 * std::numbers::pi * f); };
  const std::vector<double> hz = noise::bound_frequencies(interval, horizon);
  const NoiseBound bound = noise::tightest_bound(spectrum(hz, flicker), interval, {.horizon_s = horizon});
  EXPECT_EQ(bound.markov.size(), 2U);
  for (double f = hz.front(); f <= hz.back(); f *= 1.01)  // between the frequencies of the program, too
    EXPECT_GE(noise::density(bound, f, interval), 0.99 * flicker(f)) << f;
  EXPECT_LT(bound.tightness, 1.1);  // two processes reach 1.08 of flicker over six decades
  const NoiseBound two = noise::tightest_bound(spectrum(hz, flicker), interval, {.horizon_s = horizon}, 0);
  EXPECT_GT(two.tightness, bound.tightness);
  EXPECT_TRUE(two.markov.empty());
}

TEST(NoiseBound, DensityIsThatOfTheSampledStates) {
  // The spectrum of a sampled process is the sum of its covariances sigma^2 a^|k|.
  const NoiseBound bound{.markov = {{2, 0.5}}};
  const double f = 0.7, a = std::exp(-interval / 0.5);
  double sum = 4;
  for (int k = 1; k < 4000; ++k) sum += 8 * std::pow(a, k) * std::cos(2 * std::numbers::pi * f * interval * k);
  EXPECT_NEAR(noise::density(bound, f, interval), interval * sum, 1e-9);
}

TEST(NoiseBound, BelowTheReachOfTheLogDensitiesRise) {
  const auto at = noise::at_frequencies({{1, 2}, {100, 0.02}}, {0.1, 1, 10, 1000});
  EXPECT_NEAR(at[0].density, 200, 1e-9);
  EXPECT_NEAR(at[1].density, 2, 1e-12);
  EXPECT_NEAR(at[2].density, 0.2, 1e-12);
  EXPECT_NEAR(at[3].density, 0.02, 1e-12);
}

TEST(NoiseBound, OfWhiteNoiseIsTheOneSidedIntervalOfItsPower) {
  constexpr std::size_t samples = 200000;
  const NoiseFit fit = fit_noise(white_log(samples, 5), interval, {.bound = BoundOptions{.horizon_s = 60}});
  ASSERT_TRUE(fit.bound);
  // The power of n ordinates has the relative standard deviation sqrt(2 / n). Other terms, which the log does not exclude, take some of it.
  const double expected = 1 + 1.645 * std::sqrt(2.0 / samples);
  const double found = fit.bound->upper.back().density / (fit.N.value * fit.N.value);
  EXPECT_GT(found - 1, 0.8 * (expected - 1));
  EXPECT_LT(found - 1, 2 * (expected - 1));
  for (const UpperDensity& u : fit.bound->upper) EXPECT_GE(noise::density(*fit.bound, u.hz, interval), 0.9999 * u.density);
  for (const BoundCoast& c : fit.bound->coast) EXPECT_GE(c.ratio, 1) << c.time_s;
}

TEST(NoiseBound, QuantizationIsNotPartOfIt) {
  std::vector<double> rate = white_log(100000, 7);
  const RandomStream draws(7, "quantization of a bound");
  double before = 0;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    const double now = 0.05 * draws.normal(i);
    rate[i] += (now - before) / interval, before = now;
  }
  const NoiseFit fit = fit_noise(rate, interval, {.bound = BoundOptions{.horizon_s = 60}});
  EXPECT_NEAR(fit.Q.value, 0.05, 0.005);
  EXPECT_LT(fit.bound->N, 1.2);  // its spectrum reaches 4 Q^2 / T = 1 at half the rate, beside N = 1
}

TEST(NoiseBound, HorizonBeyondAThirdOfTheLogIsRefused) {
  const std::vector<double> rate = white_log(10000, 1);
  EXPECT_THROW(fit_noise(rate, interval, {.bound = BoundOptions{.horizon_s = 34}}), Unsupported);
  EXPECT_NO_THROW(fit_noise(rate, interval, {.bound = BoundOptions{.horizon_s = 33}}));
  EXPECT_THROW(fit_noise(rate, interval, {.bound = BoundOptions{.horizon_s = -1}}), Error);
  EXPECT_THROW(fit_noise(rate, interval, {.bound = BoundOptions{.horizon_s = 10, .confidence = 1}}), Error);
}

TEST(NoiseModelTermsOf, TextAreFittedAlone) {
  std::vector<double> rate = white_log(60000, 3);
  add_process(rate, 1, 5, interval, RandomStream(3, "process"));
  const NoiseFit fit = fit_noise(rate, interval, {.model = parse_noise_terms("N, M1")});
  ASSERT_EQ(fit.markov.size(), 1U);
  const auto& [sigma, time] = fit.markov[0];
  EXPECT_NEAR(sigma.value, 1, 3.3 * sigma.standard_uncertainty);
  EXPECT_NEAR(time.value, 5, 3.3 * time.standard_uncertainty);
  for (const NoiseCoefficient& c : {fit.Q, fit.B, fit.K}) EXPECT_TRUE(!c.determined && c.upper == 0);
  EXPECT_EQ(to_string(parse_noise_terms("K N,M1  M2")), "N, K, M1, M2");
  for (const char* wrong : {"", "B", "N,N", "N,M2", "N,M1,M2,M3", "N,X", "n"}) EXPECT_THROW(parse_noise_terms(wrong), Error) << wrong;
}

}  // namespace
}  // namespace imulab
