// Simulated rates with known coefficients: by imulab's own simulation, and by another construction of every term.
#include "imulab/estimate/noise/noise_fit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/model/sensor_noise.hpp"

#include <gmock/gmock.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

constexpr double interval = 0.1;

std::vector<double> simulated(const NoiseModel& m, std::size_t n, std::uint64_t seed) {
  std::vector<double> rate(n);
  const AxisNoise noise(m, interval, seed, "noise of a test");
  noise.add_slow(rate);
  noise.add_fast(0, rate);
  return rate;
}

/// Flicker as 28 independent first-order processes, an octave apart, of equal variance B^2 ln 2 / pi: their sum's density is B^2 / (2 pi f) within 1
/// %. Each sample is the exact mean of the processes, and of the walk, over its interval.
class Construction {
 public:
  Construction(double B, double K, std::uint64_t seed) : walk_step_(K * std::sqrt(interval)), start_(count) {
    RandomStream(seed, "start").normals(0, start_);
    const double variance = B * B * std::log(2.0) / std::numbers::pi;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = 64 * std::pow(2.0, -static_cast<double>(i));  // pole times interval
      Process& p = processes_[i];
      p.decay = std::exp(-x);
      p.state = std::sqrt(variance) * start_[i];
      p.kept = -std::expm1(-x) / x;
      // Of the state's and the mean's driven parts: standard deviations, and what the mean shares with the state. The mean's variance by its series
      // where rounding would spoil it.
      const double of_state = -std::expm1(-2 * x), shared = std::pow(std::expm1(-x), 2) / x;
      const double of_mean = x > 1e-2 ? (2 * x + 4 * std::expm1(-x) - std::expm1(-2 * x)) / (x * x) : x * (2.0 / 3 - x / 2);
      p.driven = std::sqrt(variance * of_state);
      p.mean_shared = std::sqrt(variance) * shared / std::sqrt(of_state);
      p.mean_own = std::sqrt(variance * std::max(0.0, of_mean - shared * shared / of_state));
    }
  }
  /// The next sample, from `draws` normal numbers.
  static constexpr std::size_t count = 28, draws = 2 * count + 2;
  double next(const double* z) {
    double sum = walk_ + walk_step_ * (0.5 * z[0] + z[1] / std::sqrt(12.0));
    walk_ += walk_step_ * z[0];
    for (std::size_t i = 0; i < count; ++i) {
      Process& p = processes_[i];
      const double a = z[2 + 2 * i], b = z[3 + 2 * i];
      sum += p.kept * p.state + p.mean_shared * a + p.mean_own * b;
      p.state = p.decay * p.state + p.driven * a;
    }
    return sum;
  }

 private:
  struct Process {
    double decay, state, kept, driven, mean_shared, mean_own;
  };
  std::array<Process, count> processes_{};
  double walk_ = 0, walk_step_;
  std::vector<double> start_;
};

std::vector<double> constructed(const NoiseModel& m, std::size_t n, std::uint64_t seed) {
  Construction slow(m.B, m.K, seed);
  const RandomStream stream(seed, "constructed");
  std::vector<double> rate(n), z(Construction::draws + 2);
  double before = stream.normal((n + 1) * z.size());
  for (std::size_t k = 0; k < n; ++k) {
    stream.normals(k * z.size(), z);
    const double white = z[Construction::draws], error = z[Construction::draws + 1];
    rate[k] =
        slow.next(z.data()) + m.N / std::sqrt(interval) * white + m.Q / interval * (error - before) + m.R.value * interval * static_cast<double>(k);
    before = error;
  }
  return rate;
}

struct Held {
  int determined = 0, held = 0;
  double error2 = 0, stated2 = 0;
};

std::array<Held, 5> count(const NoiseModel& truth, std::size_t logs) {
  std::vector<NoiseFit> fits(logs);
  tbb::parallel_for(std::size_t{0}, logs, [&](std::size_t k) {
    fits[k] = fit_noise(k % 2 == 0 ? simulated(truth, 12000, 1 + k) : constructed(truth, 12000, 1 + k), interval);
  });
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

/// 100 logs of 20 minutes with each of two IMUs; the binomial bands of 99.9 % for intervals of 95 %. Bounds of what is absent, or hardly seen, may
/// hold more often.
TEST(NoiseFit, IntervalsHoldAsOftenAsTheySay) {
  constexpr int logs = 100;
  const double least = binomial_quantile(0.0005, logs, 0.95);
  const auto rich = count({.Q = 0.5, .N = 1, .B = 0.5, .K = 0.03}, logs);
  const auto walk = count({.N = 1, .K = 0.1, .R = {0.01, true}}, logs);
  for (const auto& held : {rich, walk})
    for (std::size_t j = 0; j < 5; ++j) EXPECT_GE(held[j].held, least) << "QNBKR"[j];
  for (const Held& h : {rich[0], rich[1], rich[2], walk[1]}) {
    EXPECT_GE(h.determined, 0.9 * logs);
    // The mean of 100 squares scatters by a seventh: three of them.
    EXPECT_NEAR(h.error2 / h.stated2, 1, 0.43);
  }
  // What is absent is not stated: 2.5 % by chance, where a bound at zero lets only one side err.
  for (const Held& h : {rich[4], walk[0], walk[2]}) EXPECT_LE(h.determined, logs - least);
}

TEST(NoiseFit, LeavesOutWhatALowPassTook) {
  std::vector<double> rate = constructed({.N = 1, .B = 0.5}, 50000, 3);
  double state = 0;
  for (double& r : rate) r = state += 0.5 * (r - state);  // half the power is lost at 1.1 Hz
  const NoiseFit fit = fit_noise(rate, interval);
  EXPECT_TRUE(fit.cut);
  EXPECT_LT(fit.highest_hz, 1.5);
  EXPECT_NEAR(fit.N.value, 1, 0.15) << "what remains of the filter below the cut";
}

TEST(NoiseFit, SaysWhereALineIs) {
  std::vector<double> rate = constructed({.N = 1}, 20000, 4);
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] += 0.5 * std::sin(2 * std::numbers::pi * static_cast<double>(k) * interval / 80);
  const NoiseFit fit = fit_noise(rate, interval);
  EXPECT_FALSE(fit.accepted);
  EXPECT_GT(fit.chi2_per_dof, 2);
  EXPECT_TRUE(std::any_of(fit.misfits.begin(), fit.misfits.end(), [](const NoiseMisfit& m) { return m.low_hz < 1 / 80.0 && 1 / 80.0 < m.high_hz; }));
}

TEST(NoiseFit, ScalesWithUnitsAndIgnoresTheMean) {
  std::vector<double> rate = constructed({.N = 1, .B = 0.3, .R = {0.01, true}}, 8192, 5);
  const NoiseFit fit = fit_noise(rate, interval);
  for (double& r : rate) r = 1e-6 * r + 9.8;
  const NoiseFit small = fit_noise(rate, interval);
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

}  // namespace
}  // namespace imulab
