// Simulated rates with known coefficients, from imulab's simulation and from another construction of every term.
#include "imulab/noise/noise_fit.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise.hpp"

#include <gmock/gmock.h>

#include "tests/flicker_log.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

constexpr double sample_s = 0.1;

std::vector<double> simulated(const NoiseModel& m, std::size_t n, std::uint64_t seed) {
  std::vector<double> rate(n);
  const AxisNoise noise(m, sample_s, seed, "noise of a test");
  noise.add_slow(rate);
  noise.add_fast(0, rate);
  return rate;
}

std::vector<double> constructed(const NoiseModel& m, std::size_t n, std::uint64_t seed) {
  const RandomStream stream(seed, "constructed");
  std::vector<double> rate(n);
  add_flicker(rate, m.B, sample_s, seed);
  double before = stream.normal(4 * n), walk = 0;
  const double step = m.K * std::sqrt(sample_s);
  std::array<double, 4> z{};
  for (std::size_t k = 0; k < n; ++k) {
    stream.normals(4 * k, z);
    rate[k] += m.N / std::sqrt(sample_s) * z[0] + m.Q / sample_s * (z[1] - before) + m.R.value * sample_s * static_cast<double>(k);
    rate[k] += walk + step * (0.5 * z[2] + z[3] / std::sqrt(12.0));  // exact mean of the walk over the interval
    walk += step * z[2];
    before = z[1];
  }
  return rate;
}

struct Held {
  int determined = 0, held = 0;
  double error2 = 0, stated2 = 0;
};

std::array<Held, 5> count(const NoiseModel& truth, std::size_t logs) {
  std::vector<NoiseFit> fits(logs);
  parallel_for(logs,
               [&](std::size_t k) { fits[k] = fit_noise(k % 2 == 0 ? simulated(truth, 12000, 1 + k) : constructed(truth, 12000, 1 + k), sample_s); });
  std::array<Held, 5> out;
  for (const NoiseFit& f : fits) {
    const std::array<const NoiseCoefficient*, 5> found{&f.Q, &f.N, &f.B, &f.K, &f.R};
    const std::array<double, 5> value{truth.Q, truth.N, truth.B, truth.K, truth.R.value};
    for (std::size_t j = 0; j < 5; ++j) {
      out[j].determined += found[j]->determined;
      out[j].held += found[j]->lower <= value[j] && value[j] <= found[j]->upper;
      if (!found[j]->determined) continue;
      out[j].error2 += std::pow(found[j]->value - value[j], 2);
      out[j].stated2 += std::pow(found[j]->standard_uncertainty, 2);
    }
  }
  return out;
}

/// 100 logs of 20 minutes with each of two IMUs; the bands are binomial at 99.9 % for 95 % intervals. Bounds of absent or barely detectable terms may
/// contain the truth more often.
TEST(NoiseFit, IntervalsHoldAsOftenAsTheySay) {  // ctest: long
  constexpr int logs = 100;
  const double least = binomial_quantile(0.0005, logs, 0.95);
  const auto rich = count({.Q = 0.5, .N = 1, .B = 0.5, .K = 0.03}, logs);
  const auto walk = count({.N = 1, .K = 0.1, .R = {0.01, true}}, logs);
  for (const auto& held : {rich, walk})
    for (std::size_t j = 0; j < 5; ++j) EXPECT_GE(held[j].held, least) << "QNBKR"[j];
  for (const Held& h : {rich[0], rich[1], walk[1]}) EXPECT_GE(h.determined, 0.9 * logs);
  EXPECT_GE(rich[2].determined, 0.5 * logs) << "in twenty minutes a process often explains flicker better";
  for (const Held& h : {rich[0], rich[1], rich[2], walk[1]})  // the mean of n squares scatters by sqrt(2 / n): three of them
    EXPECT_NEAR(h.error2 / h.stated2, 1, 3 * std::sqrt(2.0 / h.determined));
  // Absent terms are stated with probability 2.5 % by chance, because a bound at zero leaves errors on one side only.
  for (const Held& h : {rich[4], walk[0], walk[2]}) EXPECT_LE(h.determined, logs - least);
}

/// Applies y += 0.5 (x - y): a first-order filter, but not the Butterworth filter of the bilinear transform.
void smooth(std::vector<double>& rate) {
  double state = 0;
  for (double& r : rate) r = state += 0.5 * (r - state);  // half the power is lost at 1.1 Hz
}

TEST(NoiseFit, LeavesOutWhatAnUnknownFilterTook) {
  std::vector<double> rate = constructed({.N = 1, .B = 0.5}, 50000, 3);
  smooth(rate);
  smooth(rate);
  const NoiseFit fit = fit_noise(rate, sample_s);
  EXPECT_TRUE(fit.low_pass || fit.cut);
  EXPECT_NEAR(fit.N.value, 1, 0.1) << "what remains of the filter below the cut";
}

TEST(NoiseFit, KnowsAButterworthFilter) {
  // The filter is bilinear, first order, with cutoff tan(pi f T) = 1/3: half the power at 1.024 Hz.
  std::vector<double> rate = constructed({.N = 1}, 50000, 3);
  double x = 0, y = 0;
  for (double& r : rate) {
    y = 0.25 * (r + x) + 0.5 * y;
    x = r;
    r = y;
  }
  const NoiseFit fit = fit_noise(rate, sample_s);
  ASSERT_TRUE(fit.low_pass);
  EXPECT_EQ(fit.low_pass->order, 1);
  EXPECT_TRUE(fit.low_pass->digital);
  EXPECT_FALSE(fit.cut);
  EXPECT_LT(fit.low_pass->cutoff_hz.lower, 1.0242);
  EXPECT_GT(fit.low_pass->cutoff_hz.upper, 1.0242);
  EXPECT_LT(fit.N.lower, 1);
  EXPECT_GT(fit.N.upper, 1);
}

TEST(NoiseFit, FindsLinesAndTakesThemOut) {
  std::vector<double> rate = constructed({.N = 1}, 20000, 4);
  const auto sine = [](double hz, std::size_t k) { return std::sin(2 * std::numbers::pi * hz * static_cast<double>(k) * sample_s); };
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] += 0.5 * sine(1 / 80.0, k) + 2 * sine(3.21, k);
  const NoiseFit fit = fit_noise(rate, sample_s);
  ASSERT_EQ(fit.lines.size(), 2u);
  EXPECT_NEAR(fit.lines[0].hz, 1 / 80.0, 5e-5) << "a tenth of one over the record";
  EXPECT_NEAR(fit.lines[1].hz, 3.21, 5e-5);
  for (const auto& [line, truth] : {std::pair{fit.lines[0], 0.5}, std::pair{fit.lines[1], 2.0}}) {
    // White noise of density 1 in 2000 s gives sqrt(2 / 2000); leakage of the lines into adjacent ordinates increases it.
    EXPECT_GT(line.amplitude.standard_uncertainty, 0.8 * std::sqrt(1e-3));
    EXPECT_LT(line.amplitude.standard_uncertainty, 1.6 * std::sqrt(1e-3));
    EXPECT_NEAR(line.amplitude.value, truth, 4 * std::sqrt(1e-3));
  }
  EXPECT_TRUE(fit.accepted());
  EXPECT_LT(fit.N.lower, 1);
  EXPECT_GT(fit.N.upper, 1);
}

TEST(NoiseFit, FindsAMarkovProcess) {
  std::vector<double> rate = constructed({.N = 1}, 50000, 5);
  add_process(rate, 1, 5, sample_s, RandomStream(5, "process"));
  const NoiseFit fit = fit_noise(rate, sample_s);
  ASSERT_EQ(fit.markov.size(), 1u);
  for (const auto& [found, truth] : {std::pair{fit.markov[0].sigma, 1.0}, std::pair{fit.markov[0].time, 5.0}, std::pair{fit.N, 1.0}}) {
    EXPECT_LT(found.lower, truth);
    EXPECT_GT(found.upper, truth);
  }
}

TEST(NoiseFit, KnowsTheStepOfRoundedReadings) {
  std::vector<double> rate = constructed({.N = 1}, 20000, 6);
  EXPECT_EQ(resolution_of(rate), 0);
  const double step = 2;  // for a scatter of 3.2
  for (double& r : rate) r = 9.8 + step * std::round(r / step);
  EXPECT_NEAR(resolution_of(rate), step, 1e-9);
  const NoiseFit fit = fit_noise(rate, sample_s);
  EXPECT_LT(fit.N.lower, 1) << "without the rounding's own noise, a 33rd of the power";
  EXPECT_GT(fit.N.upper, 1);
}

TEST(NoiseFit, SaysWhatTheModelDoesNotHave) {
  // A broad resonance is neither a line nor a process without oscillation.
  std::vector<double> rate = constructed({.N = 1}, 50000, 7);
  std::vector<double> z(rate.size());
  RandomStream(7, "resonance").normals(0, z);
  double a = 0, b = 0;
  for (std::size_t k = 0; k < rate.size(); ++k) {
    const double y = 1.6 * a - 0.95 * b + 2 * z[k];
    b = a, a = y;
    rate[k] += y;
  }
  const NoiseFit fit = fit_noise(rate, sample_s);
  EXPECT_TRUE(!fit.accepted() || fit.highest_hz < 1);
}

TEST(NoiseFit, ScalesWithUnitsAndIgnoresTheMean) {
  std::vector<double> rate = constructed({.N = 1, .B = 0.3, .R = {0.01, true}}, 8192, 5);
  const NoiseFit fit = fit_noise(rate, sample_s);
  for (double& r : rate) r = 1e-6 * r + 9.8;
  const NoiseFit small = fit_noise(rate, sample_s);
  EXPECT_NEAR(small.N.value, 1e-6 * fit.N.value, 1e-10);  // readings near 9.8 are rounded to 2e-15
  EXPECT_NEAR(small.R.value, 1e-6 * fit.R.value, 1e-12);
  EXPECT_EQ(small.B.determined, fit.B.determined);
}

TEST(NoiseFit, RefusesWhatSaysNothing) {
  EXPECT_THROW(fit_noise(std::vector<double>(1000, 2.0), 0.1), Unsupported);
  EXPECT_THROW(fit_noise(std::vector<double>(63, 2.0), 0.1), Error);
  std::vector<double> rate = constructed({.N = 1}, 100, 6);
  EXPECT_THROW(fit_noise(rate, -1), Error);
  EXPECT_NO_THROW(fit_noise(rate, 1));
  rate[7] = INFINITY;
  EXPECT_THROW(fit_noise(rate, 1), Error);
}

/// The interval of both is that of logs which determine neither, a choice that the same noise makes.
TEST(NoiseFit, BAndKTogetherWhereNeitherIsDetermined) {
  constexpr std::size_t logs = 60;
  const NoiseModel truth{.N = 1, .B = 0.2, .K = 0.02};
  std::vector<NoiseFit> fits(logs);
  parallel_for(logs, [&](std::size_t k) { fits[k] = fit_noise(constructed(truth, 12000, 100 + k), sample_s); });
  double joint = 0, held = 0;
  for (const NoiseFit& f : fits) {
    if (!f.joint) continue;
    EXPECT_FALSE(f.B.determined || f.K.determined);
    const double variance = 2 * std::numbers::ln2 / std::numbers::pi * truth.B * truth.B + truth.K * truth.K * f.joint->tau_s / 3;
    const NoiseCoefficient& c = f.joint->deviation;
    EXPECT_LT(c.lower, c.value);
    EXPECT_LT(c.value, c.upper);
    EXPECT_LE(c.upper, std::hypot(std::sqrt(2 * std::numbers::ln2 / std::numbers::pi) * f.B.upper, f.K.upper * std::sqrt(f.joint->tau_s / 3)) * 1.02)
        << "both at their bounds is more than the log permits";
    ++joint, held += c.lower * c.lower <= variance && variance <= c.upper * c.upper;
  }
  EXPECT_GE(joint, 15) << "of 60 logs";
  EXPECT_GE(held, binomial_quantile(0.001, static_cast<int>(joint), 0.95));
}

}  // namespace
}  // namespace imulab
