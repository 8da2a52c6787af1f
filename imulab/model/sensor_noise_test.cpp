// Compares each noise term with its closed-form Allan deviation (IEEE Std 952).
#include "imulab/model/sensor_noise.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/filter_flicker.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace imulab {
namespace {

constexpr double interval = 0.01;
constexpr double rare = 1e-6;  // false-alarm probability of a bound; the seeds are 1, 2, ...

std::vector<double> samples(const NoiseModel& model, std::size_t count, std::uint64_t seed) {
  std::vector<double> out(count);
  const AxisNoise noise(model, interval, seed, "test");
  noise.add_slow(out);
  noise.add_fast(0, out);
  return out;
}

struct Allan {
  double variance = 0, pairs = 0;
};

/// Returns the Allan variance from pairs of adjacent clusters of `m` samples, with no cluster in two pairs and one sample between pairs: the pairs
/// are independent if the noise's increments (or those of its integral, or of its sum) are.
Allan allan(const NoiseModel& model, std::size_t m) {
  Allan a;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const std::vector<double> x = samples(model, 1 << 17, seed);
    for (std::size_t begin = 0; begin + 2 * m <= x.size(); begin += 2 * m + 1) {
      double first = 0, second = 0;
      for (std::size_t k = 0; k < m; ++k) first += x[begin + k], second += x[begin + m + k];
      a.variance += std::pow((second - first) / static_cast<double>(m), 2) / 2;
      ++a.pairs;
    }
  }
  a.variance /= a.pairs;
  return a;
}

void expect_variance(const NoiseModel& model, double (*closed_form)(double tau), double degrees_of_freedom_of_a_pair, double model_tolerance) {
  for (const std::size_t m : {16u, 128u, 1024u}) {
    const Allan a = allan(model, m);
    const double dof = a.pairs * degrees_of_freedom_of_a_pair, expected = closed_form(static_cast<double>(m) * interval);
    EXPECT_GT(a.variance / expected * dof, (1 - model_tolerance) * chi_square_quantile(rare / 2, dof)) << m;
    EXPECT_LT(a.variance / expected * dof, (1 + model_tolerance) * chi_square_quantile(1 - rare / 2, dof)) << m;
  }
}

TEST(SensorNoise, AllanDeviationOfWhiteNoise) {
  expect_variance(
      {.N = 2}, [](double tau) { return 4 / tau; }, 1, 0);
}

TEST(SensorNoise, AllanDeviationOfQuantization) {
  expect_variance(
      {.Q = 2}, [](double tau) { return 3 * 4 / (tau * tau); }, 1, 0);
}

TEST(SensorNoise, AllanDeviationOfRateRandomWalk) {
  // A sample is the mean of the walk at its ends: (1 + 1/(2 m^2)) of the variance, 0.2 % at m = 16.
  expect_variance(
      {.K = 2}, [](double tau) { return 4 * tau / 3; }, 1, 2e-3);
}

TEST(SensorNoise, AllanDeviationOfBiasInstability) {
  // Adjacent pairs of flicker are slightly correlated: half of their number is a safe count. The model is within 1 % of the plateau from 16 to 10^4
  // samples (its spectrum, integrated numerically).
  expect_variance(
      {.B = 2}, [](double) { return 4 * 2 * std::numbers::ln2 / std::numbers::pi; }, 0.5, 0.01);
}

// The formula for a first-order process is IEEE Std 952, C.1.5.
TEST(FilterFlicker, HasTheAllanDeviationOfBiasInstability) {
  constexpr double T = FilterFlicker::time, within = 0.11;
  const FilterFlicker f(1);
  for (double tau = 10; tau <= 1000; tau *= 1.5) {
    const double x = tau / T;
    const double process = 2 * f.sigma * f.sigma / x * (1 - (3 - 4 * std::exp(-x) + std::exp(-2 * x)) / (2 * x));
    const double variance = f.white * f.white / tau + process + f.walk * f.walk * tau / 3;
    EXPECT_NEAR(std::sqrt(variance / (2 * std::numbers::ln2 / std::numbers::pi)), 1, within) << tau;
  }
}

TEST(SensorNoise, AllanDeviationOfARampIsExact) {
  const NoiseModel model{.R = {2, true}};
  for (const std::size_t m : {16u, 1024u}) {
    const double tau = static_cast<double>(m) * interval;
    EXPECT_NEAR(std::sqrt(allan(model, m).variance), 2 * tau / std::numbers::sqrt2, 1e-9 * tau);  // means of values up to 2600, rounded
  }
}

TEST(SensorNoise, TurnOnBiasAndRampAreDrawnOnceOrFixed) {
  const std::vector<double> fixed = samples({.R = {}, .turn_on = {3, true}}, 100, 1);
  EXPECT_EQ(fixed, std::vector<double>(100, 3.0));
  double square = 0;
  const int n = 1000;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const std::vector<double> x = samples({.turn_on = {3, false}}, 2, seed);
    EXPECT_EQ(x[0], x[1]);
    square += std::pow(x[0] / 3, 2);
  }
  EXPECT_GT(square, chi_square_quantile(rare / 2, n));
  EXPECT_LT(square, chi_square_quantile(1 - rare / 2, n));
}

TEST(SensorNoise, FlickerIsStationaryFromTheStart) {
  // The variance is equal in the first sample and much later, from many starts.
  double first = 0, later = 0;
  const int n = 4000;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const std::vector<double> x = samples({.B = 1}, 600, seed);
    first += x.front() * x.front(), later += x.back() * x.back();
  }
  // This is a ratio of two chi-squares with n degrees of freedom, independent or positively correlated: five sigma of its logarithm.
  EXPECT_NEAR(std::log(first / later), 0, 5 * std::sqrt(4.0 / n));
}

TEST(SensorNoise, APartIsThePartOfTheWhole) {
  const AxisNoise noise({.Q = 1, .N = 1}, interval, 1, "test");
  std::vector<double> whole(3000), part(777);
  noise.add_fast(0, whole);
  noise.add_fast(1001, part);
  for (std::size_t k = 0; k < part.size(); ++k) EXPECT_EQ(part[k], whole[1001 + k]);
}

}  // namespace
}  // namespace imulab
