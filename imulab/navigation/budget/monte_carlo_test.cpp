#include "imulab/navigation/budget/monte_carlo.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/budget/specification.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/parallel.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

namespace imulab {
namespace {

using namespace motion;

NominalMotion at_rest(double duration, double interval) {
  NavigationState state;
  state.latitude = 0.7;
  const LocalEarth earth = local_earth(state.latitude, 0);
  NominalMotion m{{0}, {state}, {}};
  for (double t = interval; t <= duration * (1 + 1e-12); t += interval) {
    m.time.push_back(t);
    m.states.push_back(state);
    m.increments.push_back({interval * earth.rate, -interval * earth.gravity});
  }
  return m;
}

/// Compares a sample's sigma with the true one: four of its sampling sigmas.
void expect_sigma(double found, double expected, std::uint64_t runs, const std::string& what) {
  EXPECT_NEAR(found / expected, 1, 4 / std::sqrt(2 * static_cast<double>(runs))) << what;
}

/// Compares position, velocity and attitude at the end with the linear result.
void expect_as_linear(const NominalMotion& motion, const ErrorSources& sources, const StrapdownOptions& strapdown, std::uint64_t runs) {
  const ErrorBudget linear = error_budget(motion, sources, {.strapdown = strapdown, .output_interval = 1e9});
  const ErrorDistribution full = error_monte_carlo(motion, sources, {.strapdown = strapdown, .output_interval = 1e9, .runs = runs});
  for (int row = 0; row < budget_quantities; ++row)
    expect_sigma(full.sigma(row, 0), std::sqrt(linear.covariance.back()(row, row)), runs, "quantity " + std::to_string(row));
}

constexpr FlightStart start{.latitude = 0.54, .longitude = 1.8, .height = 500, .speed = 80};

ErrorSources navigation_grade() {
  ErrorSpecification specification;
  specification.grade = "navigation";
  ErrorSources s = error_sources(specification);
  s.start.velocity.fill({0.01});
  s.start.position.fill({5});
  s.barometer = {{3}, 1, 10};
  return s;
}

TEST(ErrorMonteCarlo, SpreadsAsTheLinearCovarianceThroughATrafficPattern) {  // ctest: long
  std::vector<Segment> pattern;
  for (int leg = 0; leg < 5; ++leg) {
    pattern.push_back(straight(100));
    if (leg < 4) pattern.push_back(turn(-90 * unit::deg, 2 * unit::deg, 4));
  }
  const NominalMotion motion = nominal_motion(flight(start, pattern), 0.5);  // coarse for speed: both use the same sampling
  ErrorSources sources = navigation_grade();
  sources.start.attitude = {Spread{1e-4}, Spread{1e-4}, Spread{1e-3}};
  expect_as_linear(motion, sources, {.vertical = VerticalChannel::held}, 2000);
  expect_as_linear(motion, sources, {.vertical = VerticalChannel::free}, 200);
}

TEST(ErrorMonteCarlo, SpreadsAsTheLinearCovarianceThroughAnHoursDriveAfterAnAlignment) {  // ctest: long
  std::vector<Segment> drive{accelerate(60 / 3.6, 20)};
  for (int leg = 0; leg < 9; ++leg) {
    drive.push_back(straight(350));
    drive.push_back(turn((leg % 3 == 0 ? 90 : -90) * unit::deg, 6 * unit::deg, 3));
  }
  drive.push_back(straight(270));
  FlightStart parked = start;
  parked.height = 50;
  parked.speed = 0;
  const NominalMotion motion = nominal_motion(flight(parked, drive), 1);
  ErrorSources sources = navigation_grade();
  sources.start.aligned_over = 300;
  expect_as_linear(motion, sources, {.vertical = VerticalChannel::aided}, 500);
  sources.start.attitude[2] = {1e-3};  // given
  expect_as_linear(motion, sources, {.vertical = VerticalChannel::aided}, 500);
}

TEST(ErrorMonteCarlo, EachNoiseTermSpreadsAsItsCovariance) {
  const NominalMotion motion = at_rest(300, 0.5);
  const std::uint64_t runs = 500;
  for (const NoiseModel& noise :
       {NoiseModel{.N = 1e-4}, NoiseModel{.B = 1e-3}, NoiseModel{.K = 1e-5}, NoiseModel{.R = {1e-6}}, NoiseModel{.turn_on = {1e-3}}}) {
    ErrorSources sources;
    sources.accel_noise = noise;
    const ErrorBudget linear = error_budget(motion, sources, {.output_interval = 1e9});
    const ErrorDistribution full = error_monte_carlo(motion, sources, {.output_interval = 1e9, .runs = runs});
    for (const int row : {0, 1, 2, 3, 4, 5}) expect_sigma(full.sigma(row, 0), linear.groups.front().sigma(row, 0), runs, linear.groups.front().name);
  }
}

TEST(ErrorMonteCarlo, QuantizationLeavesItsFirstAndLastReadingAndAnAlignmentsMean) {
  ErrorSources sources;
  sources.gyro_noise.Q = 1e-6;
  sources.start.aligned_over = 100;
  const ErrorDistribution d = error_monte_carlo(at_rest(300, 0.5), sources, {.output_interval = 1e9, .runs = 1000});
  const ErrorBudget linear = error_budget(at_rest(300, 0.5), sources, {.output_interval = 1e9});
  // The intermediate readings cause g Q sqrt(0.5 s t) of velocity: 4 % of the effect of the first one, 0.2 % in the square.
  for (const int row : {0, 1, 3, 4, 6, 7, 8}) EXPECT_NEAR(d.sigma(row, 0) / linear.groups.front().sigma(row, 0), 1, 4 / std::sqrt(2000.0)) << row;
}

TEST(ErrorMonteCarlo, AtRestItsSpreadIsTheClosedForm) {
  ErrorSources sources;
  sources.accel_noise.N = 1e-4;
  sources.start.velocity[1] = {0.01};
  const std::uint64_t runs = 1000;
  const ErrorDistribution d = error_monte_carlo(at_rest(60, 0.1), sources, {.output_interval = 30, .runs = runs});
  ASSERT_EQ(d.time.size(), 2u);
  EXPECT_NEAR(d.time[0], 30, 1e-9);
  const double white = 1e-4 * std::pow(60, 1.5) / std::sqrt(3);  // within 0.1 % of Schuler's after a minute
  expect_sigma(d.sigma(0, 1), white, runs, "east");
  expect_sigma(d.sigma(1, 1), std::hypot(white, 0.01 * 60), runs, "north");
  expect_sigma(d.sigma(3, 1), 1e-4 * std::sqrt(60), runs, "velocity east");
  // The errors are Gaussian, which gives the quantiles; their sampling sigma is 2.1 times that of a mean at 5 %, 1.25 times at 50 %.
  const double mean_sigma = white / std::sqrt(runs);
  EXPECT_NEAR(d.low(0, 1), normal_quantile(0.05) * white, 4 * 2.1 * mean_sigma);
  EXPECT_NEAR(d.high(0, 1), normal_quantile(0.95) * white, 4 * 2.1 * mean_sigma);
  EXPECT_NEAR(d.median(0, 1), 0, 4 * 1.25 * mean_sigma);
  EXPECT_NEAR(d.mean(0, 1), 0, 4 * mean_sigma);
  EXPECT_NEAR(d.drift_cep * 60, d.median(9, 1), 1e-6);  // the same errors, stored as floats there
  EXPECT_EQ(d.drift.size(), runs);
  EXPECT_TRUE((d.peak.array() >= d.end.array().abs()).all());
  EXPECT_GT(d.drift_95, d.drift_rms);
  EXPECT_GT(d.drift_rms, d.drift_cep);
}

TEST(ErrorMonteCarlo, FixedErrorsAloneAreOneRunWithoutSpread) {
  ErrorSources sources;
  sources.coefficients = {coefficient_index("accel.offset.x")};
  sources.fixed = Eigen::VectorXd::Constant(1, 1e-3);
  sources.covariance = Eigen::MatrixXd::Zero(1, 1);
  const ErrorDistribution d = error_monte_carlo(at_rest(60, 0.1), sources, {.output_interval = 60, .runs = 3});
  EXPECT_NEAR(d.mean(0, 0), 0.5e-3 * 60 * 60, 0.001 * 1.8);  // Schuler: (W t)^2/12 = 0.05 %
  EXPECT_LT(d.sigma(0, 0), 1e-7);                            // for three equal floats
}

TEST(ErrorMonteCarlo, IsBitEqualOnAnyNumberOfThreadsAndTellsItsProgress) {
  ErrorSources sources = navigation_grade();
  sources.start.aligned_over = 10;
  const NominalMotion motion = at_rest(20, 0.1);
  std::atomic<std::uint64_t> most = 0;
  const MonteCarloOptions options{.strapdown = {.vertical = VerticalChannel::aided}, .runs = 20};
  const ErrorDistribution many = error_monte_carlo(motion, sources, options, [&](std::uint64_t done) {
    for (std::uint64_t seen = most; seen < done && !most.compare_exchange_weak(seen, done);) {
    }
  });
  const ThreadLimit one_thread(1);
  const ErrorDistribution one = error_monte_carlo(motion, sources, options);
  EXPECT_EQ(many.end, one.end);
  EXPECT_EQ(many.sigma, one.sigma);
  EXPECT_EQ(most, 20u);
}

TEST(ErrorMonteCarlo, RefusesWhatDoesNotFitOrIsNone) {
  const NominalMotion motion = at_rest(10, 1);
  EXPECT_THROW(error_monte_carlo(motion, ErrorSources{}, {.runs = 0}), Error);
  EXPECT_THROW(error_monte_carlo(at_rest(3000, 1), ErrorSources{}, {.output_interval = 1, .runs = 1000000}), Error);
  EXPECT_THROW(error_monte_carlo(motion, ErrorSources{}, {.output_interval = -1}), Error);
  EXPECT_THROW(error_monte_carlo({}, ErrorSources{}, {}), Error);
}

}  // namespace
}  // namespace imulab
