// Lines in simulated rates: true lines are found, and no others.
#include "imulab/core/parallel.hpp"
#include "imulab/core/random.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise/noise_terms.hpp"

#include <gtest/gtest.h>

#include "tests/flicker_log.hpp"
#include <cmath>
#include <numbers>

namespace imulab::noise {
namespace {

constexpr double interval = 1;

std::vector<double> log_of(const NoiseModel& m, std::size_t samples, std::uint64_t seed) {
  std::vector<double> rate(samples);
  add_flicker(rate, m.B, interval, seed);
  const AxisNoise noise({.N = m.N, .K = m.K}, interval, seed, "noise without lines");
  noise.add_slow(rate);
  noise.add_fast(0, rate);
  return rate;
}

/// One log of a thousand may have a line. If the median were used as the density itself, one in 45 would.
TEST(NoiseLines, NoiseAloneHasNone) {  // ctest: long
  constexpr std::size_t logs = 300, samples = 16384;
  for (const NoiseModel& m : {NoiseModel{.N = 1}, NoiseModel{.N = 1, .B = 0.3, .K = 0.003}, NoiseModel{.N = 1, .K = 0.3}}) {
    std::vector<std::size_t> lines(logs);
    parallel_for(logs, [&](std::size_t i) { lines[i] = without_lines(log_of(m, samples, i + 1), interval).lines.size(); });
    std::size_t with_lines = 0;
    for (const std::size_t count : lines) with_lines += count > 0;
    EXPECT_LE(with_lines, 4u) << "of 0.3 expected; more than 4 have a chance of 2e-5";
  }
}

TEST(NoiseLines, OneThatStandsOutIsFoundWithItsFrequencyAndAmplitude) {
  constexpr std::size_t logs = 40, samples = 16384;
  const double hz = 0.0127, amplitude = 0.12, sigma = std::sqrt(2.0 / samples);  // white noise of density 1: 10.9 sigma
  std::vector<std::vector<NoiseLine>> found(logs);
  parallel_for(logs, [&](std::size_t i) {
    std::vector<double> rate = log_of({.N = 1}, samples, 1000 + i);
    const double phase = 2 * std::numbers::pi * RandomStream(1000 + i, "phase").uniform(0);
    for (std::size_t k = 0; k < samples; ++k) rate[k] += amplitude * std::sin(2 * std::numbers::pi * hz * static_cast<double>(k) + phase);
    found[i] = without_lines(rate, interval).lines;
  });
  int right = 0;
  for (const std::vector<NoiseLine>& lines : found) {
    if (lines.size() != 1) continue;
    EXPECT_NEAR(lines[0].hz, hz, 0.5 / samples);
    EXPECT_NEAR(lines[0].amplitude.value, amplitude, 4.5 * sigma);
    ++right;
  }
  // Its power is 59 times the floor, distributed over ordinates by phase and frequency; an ordinate with 33 times the floor begins a line.
  EXPECT_GE(right, 34);
}

}  // namespace
}  // namespace imulab::noise
