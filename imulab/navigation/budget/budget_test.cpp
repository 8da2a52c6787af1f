#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/budget/growth.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace imulab::budget {
namespace {

using namespace motion;

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double pi = std::numbers::pi;

/// Returns a unit that uses every term of the model, so that every error path is tested.
SensorModel crooked_unit() {
  SensorModel m;
  m.accel.offset = {0.1, 0.2, 0.3};
  m.accel.matrix << 1, 0, 0.01, 0.03, 0.9, 0, 0, 0.02, 1.1;
  m.accel.quadratic = {1e-4, 0, 2e-4};
  m.accel.thermal.col(1).setConstant(1e-3);
  m.gyro.offset = {1e-3, 0, -1e-3};
  m.gyro.matrix(0, 1) = 0.02;
  m.gyro.cubic = {0, 1e-2, 0};
  m.gyro.thermal.col(1).setConstant(1e-5);
  m.g_sensitivity.setConstant(1e-4);
  return m;
}

ErrorSources of_coefficients(const std::vector<CoefficientIndex>& coefficients) {
  ErrorSources s;
  s.coefficients = coefficients;
  s.fixed = VectorXd::Zero(static_cast<Eigen::Index>(coefficients.size()));
  s.covariance = MatrixXd::Zero(s.fixed.size(), s.fixed.size());
  return s;
}

std::vector<CoefficientIndex> followed_coefficients() {
  std::vector<CoefficientIndex> out;
  for (const CoefficientIndex i : coefficient_indices())
    if (coefficient(i).term != Term::lever_arm) out.push_back(i);
  return out;
}

/// The full integration with the tested errors.
struct Flown {
  const NominalMotion& motion;
  const ErrorSources& sources;
  StrapdownOptions options;
  ErrorState error(const SensorModel& assumed, const ErrorState& start, double barometer) const {
    Strapdown strapdown(with_error(motion.states.front(), start), options);
    for (std::size_t i = 0; i < motion.increments.size(); ++i) {
      const double T = motion.time[i + 1] - motion.time[i];
      const Motion true_motion{.rate = motion.increments[i].angle / T, .force = motion.increments[i].velocity / T};
      const Motion c = compensate(assumed, decompensate(sources.model, true_motion, sources.gyro_tau, sources.accel_tau));
      strapdown.step(Increment{c.rate * T, c.force * T}, T, motion.states[i + 1].height + barometer);
    }
    return error_of(strapdown.state(), motion.states.back());
  }
};

/// Compares two columns by attitude, velocity and position, relative to the length of the second.
void expect_near(const ErrorState& linear, const ErrorState& full, double tolerance, const std::string& what) {
  for (const int block : {ErrorIndex::attitude, ErrorIndex::velocity, ErrorIndex::position}) {
    const double length = full.segment<3>(block).norm();
    EXPECT_LT((linear - full).segment<3>(block).norm(), tolerance * length + 1e-9) << what << " " << block;  // rounding of the differences: 1e-9
  }
}

TEST(ErrorBudget, SensitivitiesAreTheDerivativesOfTheFullIntegration) {
  const Trajectory trajectory = flight({0.54, 1.8, 500, 80, 0}, {straight(20), turn(-60 * unit::deg, 2 * unit::deg, 4), climb(0.1, 10, 5),
                                                                 accelerate(20, 20), s_turn(0.5, 0.05, 3), straight(20)});
  const NominalMotion motion = nominal_motion(trajectory, 0.04);
  ErrorSources sources = of_coefficients(followed_coefficients());
  sources.model = crooked_unit();
  sources.accel_tau = {10, 5, 3};
  sources.gyro_tau = {-10, 5, 3};
  const auto n = static_cast<Eigen::Index>(sources.coefficients.size());
  for (const auto vertical : {VerticalChannel::free, VerticalChannel::fixed, VerticalChannel::aided, VerticalChannel::held}) {
    BudgetOptions options;
    options.strapdown.vertical = vertical;
    const ErrorColumns linear = error_sensitivities(motion, sources, options);
    const Flown flown{motion, sources, options.strapdown};
    const std::string channel = " of channel " + std::to_string(static_cast<int>(vertical));
    // The limit: sensor errors act at the middle of a 0.5 s block, and the roll-in lasts 4 s: (0.5/4)^2/12 = 0.13 % of the change, and several times
    // that if effects of roll-in and roll-out nearly cancel.
    const double tolerance = 5e-3;
    for (Eigen::Index k = 0; k < n; ++k) {
      const CoefficientIndex index = sources.coefficients[static_cast<std::size_t>(k)];
      if (vertical != VerticalChannel::free && k % 5 != 0) continue;  // for speed
      // The step moves the end by a meter: its quadratic part is 1e-6 and cancels in the central difference.
      const double step = 0.5 / linear.col(k).segment<3>(ErrorIndex::position).norm();
      SensorModel above = sources.model, below = sources.model;
      set_coefficient(above, index, coefficient_value(above, index) + step);
      set_coefficient(below, index, coefficient_value(below, index) - step);
      const ErrorState full = (flown.error(above, ErrorState::Zero(), 0) - flown.error(below, ErrorState::Zero(), 0)) / (2 * step);
      expect_near(linear.col(k) * step, full * step, tolerance, std::string(coefficient(index).name) + channel);
    }
    const std::array<int, 9> state{6, 7, 8, 3, 4, 5, 0, 1, 2};
    for (int k = 0; k < 9; ++k) {
      ErrorState start = ErrorState::Zero();
      start[state[static_cast<std::size_t>(k)]] = k < 3 ? 10 : k < 6 ? 0.05 : 1e-5;
      const ErrorState full = (flown.error(sources.model, start, 0) - flown.error(sources.model, -start, 0)) / 2;
      if (vertical == VerticalChannel::held && k == 2) continue;  // the barometer replaces it in the first step
      // 1e-4: place and force of the motion are taken at the middle of a block. Aided: the loop corrects at the end of each 0.04 s step, by 3/100
      // s^-1 of the height. Fixed: the computed motion does not climb and lacks the Coriolis acceleration of 5 m/s.
      const double start_tolerance = vertical == VerticalChannel::aided ? 2e-3 : vertical == VerticalChannel::fixed ? 5e-3 : 1e-4;
      expect_near(linear.col(n + 12 + k) * start.sum(), full, start_tolerance, "start " + std::to_string(k) + channel);
    }
    const ErrorState full = (flown.error(sources.model, ErrorState::Zero(), 5) - flown.error(sources.model, ErrorState::Zero(), -5)) / 2;
    expect_near(linear.col(n + 21) * 5, full, 2e-3, "barometer" + channel);  // as above
  }
}

/// Returns a rest level on the ellipsoid with body axes east, north, up.
NominalMotion at_rest(double latitude, double duration, double interval) {
  NavigationState state;
  state.latitude = latitude;
  const LocalEarth earth = local_earth(latitude, 0);
  NominalMotion m;
  m.time.push_back(0);
  m.states.push_back(state);
  for (double t = interval; t <= duration * (1 + 1e-12); t += interval) {
    m.time.push_back(t);
    m.states.push_back(state);
    m.increments.push_back({interval * earth.rate, -interval * earth.gravity});
  }
  return m;
}

/// Returns the linear error at the end due to one coefficient with this fixed error.
VectorXd end_of(const NominalMotion& motion, const char* coefficient, double size) {
  ErrorSources s = of_coefficients({coefficient_index(coefficient)});
  s.fixed[0] = size;
  return error_budget(motion, s, {.strapdown = {.vertical = VerticalChannel::fixed}, .block = 5}).groups.front().fixed.rightCols<1>();
}

TEST(ErrorBudget, AtRestErrorsGrowAsTheClosedFormsOfASchulerPendulum) {
  // With W^2 = g/R; neglecting the rotation of the axes with the Earth costs several times (w_ie t)^2/2 = 0.4 % after 20 minutes.
  const double latitude = 0.7, t = 1200, tolerance = 0.015;
  const LocalEarth earth = local_earth(latitude, 0);
  const double g = earth.gravity.norm(), north = earth.meridian_radius, east = earth.transverse_radius;
  const double Wn = std::sqrt(g / north), We = std::sqrt(g / east);
  const NominalMotion motion = at_rest(latitude, t, 5);
  enum { pE, pN, pU, vE, vN, vU, aE, aN, aU };
  const auto expect = [&](double found, double expected) { EXPECT_NEAR(found, expected, tolerance * std::abs(expected)); };

  const VectorXd bias = end_of(motion, "accel.offset.y", 1e-3);
  expect(bias[pN], 1e-3 / (Wn * Wn) * (1 - std::cos(Wn * t)));
  expect(bias[vN], 1e-3 / Wn * std::sin(Wn * t));
  const double drift = 1e-7;
  // An east gyro that reads too much turns the computed north axis up: the force that supports the body seems to point south.
  expect(end_of(motion, "gyro.offset.x", drift)[pN], -north * drift * (t - std::sin(Wn * t) / Wn));
  expect(end_of(motion, "gyro.offset.y", drift)[pE], east * drift * (t - std::sin(We * t) / We));
  const VectorXd azimuth = end_of(motion, "gyro.offset.z", drift);
  expect(azimuth[aU], -drift * t);
  expect(azimuth[pN], north * earth.rate.y() * drift * (t * t / 2 - (1 - std::cos(Wn * t)) / (Wn * Wn)));

  ErrorSources s = of_coefficients({});
  s.start.attitude = {Spread{1e-4, true}, Spread{}, Spread{}};
  const BudgetOptions options{.strapdown = {.vertical = VerticalChannel::fixed}, .block = 5};
  expect(error_budget(motion, s, options).mean(pN, error_budget(motion, s, options).mean.cols() - 1), north * 1e-4 * (1 - std::cos(Wn * t)));
  s.start.attitude = {Spread{}, Spread{}, Spread{1e-4, true}};
  expect(error_budget(motion, s, options).mean.rightCols<1>()[pN], -1e-4 * earth.rate.y() * north * (t - std::sin(Wn * t) / Wn));

  // The variance due to white noise is the integral of the squares of those responses.
  s = of_coefficients({});
  s.gyro_noise.N = 1e-6;
  s.accel_noise.N = 1e-4;
  const ErrorBudget noise = error_budget(motion, s, options);
  const auto sigma = [&](std::size_t group, Eigen::Index row) { return noise.groups[group].sigma.rightCols<1>()[row]; };
  ASSERT_EQ(noise.groups[0].name, "gyro white noise");
  expect(sigma(0, pN), 1e-6 * north * std::sqrt(1.5 * t - 2 * std::sin(Wn * t) / Wn + std::sin(2 * Wn * t) / (4 * Wn)));
  expect(noise.groups[0].sigma(aU, 5), 1e-6 * std::sqrt(60));  // early, after a minute: later it includes the longitude error times sin L
  ASSERT_EQ(noise.groups[1].name, "accelerometer white noise");
  expect(sigma(1, pN), 1e-4 / Wn * std::sqrt(t / 2 - std::sin(2 * Wn * t) / (4 * Wn)));
  expect(noise.groups[1].sigma(pN, 5), 1e-4 * std::pow(60, 1.5) / std::sqrt(3));
}

TEST(ErrorBudget, AVelocityErrorSwingsAsSchulersAndFoucaultsPendulumDo) {
  // As in the test of the full integration: frequency sqrt(g/R + (w_ie sin L)^2), in a plane that turns clockwise at w_ie sin L.
  const double latitude = 70 * unit::deg;
  ErrorSources s = of_coefficients({});
  s.start.velocity[1] = {0.1, true};
  const ErrorBudget day =
      error_budget(at_rest(latitude, 86400, 10), s, {.strapdown = {.vertical = VerticalChannel::fixed}, .output_interval = 10, .block = 10});
  const LocalEarth earth = local_earth(latitude, 0);
  const double vertical = earth.rate.z(), g = earth.gravity.norm(), radius = (earth.meridian_radius + earth.transverse_radius) / 2;
  double last = 0.1, first = 0, latest = 0, most_across = 0;
  int rises = 0;
  for (std::size_t i = 0; i < day.time.size(); ++i) {
    const double t = day.time[i], e = day.groups.front().fixed(3, static_cast<Eigen::Index>(i)),
                 n = day.groups.front().fixed(4, static_cast<Eigen::Index>(i));
    const double along = n * std::cos(vertical * t) + e * std::sin(vertical * t);
    most_across = std::max(most_across, std::abs(e * std::cos(vertical * t) - n * std::sin(vertical * t)));
    if (last < 0 && along >= 0) {
      latest = t - 10 * along / (along - last);
      if (rises++ == 0) first = latest;
    }
    last = along;
  }
  ASSERT_EQ(rises, 17);
  const double period = 2 * pi / std::sqrt(g / radius + vertical * vertical);
  EXPECT_NEAR((latest - first) / 16, period, 0.002 * period);  // 84.4 min; the two radii of the ellipsoid differ by 0.1 % there
  EXPECT_LT(most_across, 0.015);                               // hundredths: the same, and the rotation of the attitude with the Earth
}

TEST(ErrorBudget, AnAlignmentsTiltHidesTheBiasThatCausedIt) {
  // An accelerometer bias cancels with the level that it causes, at the attitude of the alignment; likewise a gyro drift with its heading.
  const NominalMotion motion = at_rest(0.7, 600, 1);
  ErrorSources s = of_coefficients({coefficient_index("accel.offset.x"), coefficient_index("gyro.offset.x")});
  s.fixed << 1e-3, 1e-7;
  s.start.aligned_over = 300;
  const ErrorBudget b = error_budget(motion, s, {.strapdown = {.vertical = VerticalChannel::fixed}});
  const double g = local_earth(0.7, 0).gravity.norm(), horizontal = earth_rate * std::cos(0.7);
  const auto row = [&](std::size_t coefficient, Eigen::Index i) { return b.coefficients[coefficient].fixed.rightCols<1>()[i]; };
  EXPECT_NEAR(row(0, 7), 1e-3 / g, 0.002 * 1e-3 / g);          // 0.2 %: (w_ie t)^2
  EXPECT_LT(std::abs(row(0, 0)), 0.002 * 0.5e-3 * 600 * 600);  // alone it would be b t^2/2
  EXPECT_NEAR(row(1, 8), -1e-7 / horizontal, 0.002 * 1e-7 / horizontal);
  EXPECT_LT(std::abs(row(1, 1)), 0.002 * 1e-7 * g * 600 * 600 * 600 / 6);
  // A given heading has an error of its own instead of the gyro's; the level remains that of the accelerometers.
  s.start.attitude[2] = {2e-3, true};
  const ErrorBudget given = error_budget(motion, s, {.strapdown = {.vertical = VerticalChannel::fixed}});
  EXPECT_NEAR(given.coefficients[0].fixed.rightCols<1>()[7], 1e-3 / g, 0.002 * 1e-3 / g);
  EXPECT_LT(std::abs(given.coefficients[1].fixed.rightCols<1>()[8]), 0.05 * 600 * 1e-7);  // it tilts; the Earth turns 4 % of that into heading
  EXPECT_NEAR(std::abs(given.mean.rightCols<1>()[8] - given.coefficients[1].fixed.rightCols<1>()[8]), 2e-3, 0.02 * 2e-3);
}

TEST(ErrorBudget, GroupsAndTheirCorrelationMakeUpTheWhole) {
  const NominalMotion motion = at_rest(0.7, 300, 1);
  ErrorSources s = of_coefficients({coefficient_index("accel.offset.x"), coefficient_index("accel.matrix.xz"), coefficient_index("gyro.offset.x")});
  const double g = local_earth(0.7, 0).gravity.norm();
  // The errors of offset and matrix element cancel exactly at this attitude: the groups are large, the total is not.
  s.covariance << 1e-6, -1e-6 / g, 0, -1e-6 / g, 1e-6 / (g * g), 0, 0, 0, 1e-14;
  s.fixed << 1e-4, 0, 2e-7;
  s.accel_noise.N = 1e-5;
  s.accel_noise.turn_on = {1e-5, true};
  const ErrorBudget b = error_budget(motion, s, {.output_interval = 100});
  EXPECT_EQ(b.time, (std::vector<double>{100, 200, 300}));
  for (int quantity = 0; quantity < budget_quantities; ++quantity) {
    const std::vector<double> shares = b.shares(quantity, 2);
    ASSERT_EQ(shares.size(), b.groups.size() + 1);
    double sum = 0;
    for (const double share : shares) sum += share;
    EXPECT_NEAR(sum, 1, 1e-6);  // fractions of canceling parts are up to 1e4 of the rest
  }
  const double alone = 1e-3 * 300 * 300 / 2;
  EXPECT_NEAR(b.groups[0].sigma(0, 2), alone, 0.02 * alone);  // 2 %: Schuler, (W t)^2/12
  EXPECT_LT(std::sqrt(b.covariance[2](0, 0)), 0.1 * alone);
  EXPECT_LT(b.shares(0, 2).back(), -1);
  EXPECT_NEAR(b.mean(0, 2), b.groups[0].fixed(0, 2) + b.coefficients[2].fixed(0, 2) + 0.5e-5 * 300 * 300, 0.02 * 0.5e-5 * 300 * 300);
}

TEST(ErrorBudget, OutputsAreTheFirstSamplesAtOrAfterTheirTimesAndTheEnd) {
  const NominalMotion motion = at_rest(0.7, 1, 0.1);  // its stamps are rounded sums of 0.1
  EXPECT_EQ(output_samples(motion, 0.3), (std::vector<std::size_t>{3, 6, 9, 10}));
  EXPECT_EQ(output_samples(motion, 0.25), (std::vector<std::size_t>{3, 5, 8, 10}));
  EXPECT_EQ(output_samples(motion, 100), (std::vector<std::size_t>{10}));
  EXPECT_EQ(output_samples(motion, 0.01).size(), 10u);
}

TEST(ErrorBudget, RefusesWhatItCannotFollow) {
  const NominalMotion motion = at_rest(0.7, 10, 1);
  EXPECT_THROW(error_budget({}, of_coefficients({})), Error);
  NominalMotion standing = motion;
  standing.time[5] = standing.time[4];
  EXPECT_THROW(error_budget(standing, of_coefficients({})), Error);
  EXPECT_THROW(error_budget(motion, of_coefficients({coefficient_index("accel.lever_arm.xx")})), Error);
  ErrorSources s = of_coefficients({CoefficientIndex(0)});
  s.fixed[0] = std::nan("");
  EXPECT_THROW(error_budget(motion, s), Error);
  s = of_coefficients({CoefficientIndex(0)});
  s.covariance(0, 0) = -1;
  EXPECT_THROW(error_budget(motion, s), Error);
  s = of_coefficients({CoefficientIndex(0), CoefficientIndex(1)});
  s.covariance << 1, 2, 2, 1;
  EXPECT_THROW(error_budget(motion, s), Error);
  s = of_coefficients({CoefficientIndex(0)});
  s.covariance.resize(0, 0);
  EXPECT_THROW(error_budget(motion, s), Error);
  s = of_coefficients({});
  s.barometer.time_constant = 0;
  EXPECT_THROW(error_budget(motion, s), Error);
  s = of_coefficients({});
  s.start.aligned_over = 0;
  EXPECT_THROW(error_budget(motion, s), Error);
  EXPECT_THROW(error_budget(motion, of_coefficients({}), {.output_interval = 0}), Error);
  EXPECT_THROW(error_budget(motion, of_coefficients({}), {.block = std::nan("")}), Error);
}

}  // namespace
}  // namespace imulab::budget
