#include "imulab/navigation/aided/aided_budget.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/budget/growth.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

using motion::NominalMotion;

constexpr double budget_step = 0.1;  // s
constexpr Eigen::Index east = 0, north = 1, up_velocity = 5;

/// Motions at rest, or driving: acceleration, a turn, straight.
NominalMotion resting(double duration) {
  return nominal_motion(motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, {motion::rest(duration)}, {.banks = false}), budget_step);
}
NominalMotion driven_around() {
  using namespace motion;
  return nominal_motion(flight({48 * unit::deg, 0.2, 500, 0, 0}, {accelerate(10, 10), turn(90 * unit::deg, 0.2, 2), straight(80)}, {.banks = false}),
                        budget_step);
}

/// Returns a receiver with white fixes of this sigma each second until `lost`.
Aid plain_receiver(const NominalMotion& motion, double sigma, double lost) {
  Aid aid{.scale = TimeScale::recording, .lever_arm_sigma = 0, .delay_sigma = 0};
  for (std::size_t i = 0; i < motion.time.size(); i += 10) {
    const NavigationState& s = motion.states[i];
    aid.record.time.push_back(std::llround(1e9 * motion.time[i]));
    aid.record.position.emplace_back(s.latitude, s.longitude, s.height);
    aid.record.position_sigma.push_back(Vector3d::Constant(sigma));
  }
  aid.outages = {{lost, motion.time.back() + 1}};
  return aid;
}

ErrorSources no_errors() {
  ErrorSources s;
  s.fixed.resize(0), s.covariance.resize(0, 0);
  return s;
}

double part_of_group(const ErrorBudget& b, const std::string& group, Eigen::Index quantity, std::size_t at) {
  for (const Contribution& c : b.groups)
    if (c.name == group) return c.sigma(quantity, static_cast<Eigen::Index>(at));
  ADD_FAILURE() << group;
  return NAN;
}

ErrorSources offset_errors(double accel) {
  ErrorSources s = no_errors();
  s.coefficients = select_coefficients("accel.offset");
  s.fixed = Eigen::Vector3d::Zero();
  s.covariance = accel * accel * Matrix3d::Identity();
  return s;
}

// An almost error-free receiver fixes position and velocity. An accelerometer's noise then grows from zero: N t^1/2 in velocity and N (t^3/3)^1/2 in
// position. The gyros' noise acts through the tilt of gravity: g N (t^3/3)^1/2 and g N (t^5/20)^1/2.
TEST(AidedBudget, NoiseGrowsAsItsIntegralsAfterTheLoss) {
  const NominalMotion motion = resting(120);
  const double lost = 60, t = 60, accel = 1e-3, gyro = 1e-5;
  ErrorSources s = no_errors();
  s.accel_noise.N = accel;
  ErrorBudget b = aided_budget(motion, s, {plain_receiver(motion, 1e-6, lost)});
  ASSERT_TRUE(b.loss);
  EXPECT_EQ(b.loss->begin, lost);
  EXPECT_EQ(b.loss->aids, std::vector<std::string>{"gnss"});
  ASSERT_DOUBLE_EQ(b.time.back(), lost + t);
  // The last fix is a second before the first lost one: the noise has had 61 s, after a small start error due to fixes at intervals of a second.
  const double since = t + 1;
  EXPECT_NEAR(part_of_group(b, "accelerometer white noise", up_velocity, b.time.size() - 1), accel * std::sqrt(since),
              0.02 * accel * std::sqrt(since));
  const double position = accel * std::sqrt(std::pow(since, 3) / 3);
  EXPECT_NEAR(part_of_group(b, "accelerometer white noise", east, b.time.size() - 1), position, 0.03 * position);
  s = no_errors();
  s.gyro_noise.N = gyro;
  b = aided_budget(motion, s, {plain_receiver(motion, 1e-6, lost)});
  const double tilted = 9.81 * gyro * std::sqrt(std::pow(since, 5) / 20);
  EXPECT_NEAR(part_of_group(b, "gyro white noise", north, b.time.size() - 1), tilted, 0.05 * tilted);  // includes the tilt that the fixes left
}

// Flicker of power B^2 / w is white noise u filtered by B (j w)^-1/2, in time B (pi t)^-1/2. If everything before the loss is observed, u then causes
// a velocity with the standard deviation B t (2 / pi)^1/2 and a height with 2/3 B t^2 / pi^1/2.
TEST(AidedBudget, FlickerGrowsAsItsSpectrumTells) {
  const NominalMotion motion = resting(360);
  const double lost = 300, t = 61, B = 1e-3;
  ErrorSources s = no_errors();
  s.accel_noise.B = B;
  const ErrorBudget b = aided_budget(motion, s, {plain_receiver(motion, 1e-6, lost)});
  constexpr double of_filter = 0.11;  // as the Allan deviation of the filter's flicker
  const double velocity = B * t * std::sqrt(2 / std::numbers::pi), height = 2. / 3 * B * t * t / std::sqrt(std::numbers::pi);
  EXPECT_NEAR(part_of_group(b, "accelerometer flicker", up_velocity, b.time.size() - 1) / velocity, 1, of_filter);
  EXPECT_NEAR(part_of_group(b, "accelerometer flicker", up_velocity - 3, b.time.size() - 1) / height, 1, of_filter);
}

// With fixes of negligible weight, every source has the same effect as without an aid, an offset 1/2 b t^2.
TEST(AidedBudget, WithAVeryBadAidItIsTheBudgetWithoutOne) {
  const NominalMotion motion = driven_around();
  ErrorSources s = offset_errors(1e-3);
  s.gyro_noise.N = 2e-5, s.accel_noise.N = 1e-3, s.gyro_noise.K = 1e-7, s.gyro_noise.turn_on = {.value = 1e-5};
  s.accel_noise.B = 1e-4;
  s.start.attitude = {Spread{1e-3}, Spread{1e-3}, Spread{5e-3}}, s.start.velocity = {Spread{0.1}, Spread{0.1}, Spread{0.1}};
  const ErrorBudget aided = aided_budget(motion, s, {plain_receiver(motion, 1e6, 60)});
  const ErrorBudget alone = error_budget(motion, s, {.output_interval = 10, .algorithm = false});
  const auto end = static_cast<Eigen::Index>(alone.time.size()) - 1;
  ASSERT_NEAR(aided.time.back(), alone.time.back(), 1e-9);
  for (const Contribution& c : alone.groups) {
    if (c.sigma.col(end).isZero(0)) continue;
    const auto found = std::ranges::find(aided.groups, c.name, &Contribution::name);
    ASSERT_NE(found, aided.groups.end()) << c.name;
    for (const Eigen::Index q : {0, 1, 3, 4, 6, 7, 8}) {
      const double expected = c.sigma(q, end), size = c.sigma.col(end).segment<3>(q / 3 * 3).maxCoeff();
      // The filter's transition neglects derivatives of Earth rate and transport rate by position, and sums samples instead of blocks. Flicker needs
      // infinitely slow processes: the filter's extend to three weeks, the others to 4^13 samples.
      const double tolerance = c.name == "accelerometer flicker" ? 0.1 : 0.02;
      EXPECT_NEAR(found->sigma(q, found->sigma.cols() - 1), expected, tolerance * size) << c.name << ", quantity " << q;
    }
  }
}

TEST(AidedBudget, AnUnseenOffsetGrowsWithTheSquareOfTheTime) {
  const double T = 90, offset = 1e-3;
  const ErrorBudget b = aided_budget(resting(T), offset_errors(offset), {plain_receiver(resting(T), 1e6, 30)});
  const double height = offset * T * T / 2;
  constexpr Eigen::Index up = 2;
  EXPECT_NEAR(part_of_group(b, "accelerometer bias", up, b.time.size() - 1), height, 5e-3 * height);  // the gradient of gravity adds 3e-6 T^2 / 12
}

// The parts add up to the filter's covariance: fractions sum to one without correlations.
TEST(AidedBudget, PartsAddUp) {
  const NominalMotion motion = driven_around();
  ErrorSources s = offset_errors(1e-2);
  s.gyro_noise.N = 2e-5, s.accel_noise.N = 1e-3, s.accel_noise.B = 1e-4, s.accel_noise.K = 1e-6;
  s.start.attitude = {Spread{1e-2}, Spread{1e-2}, Spread{0.1}}, s.start.position = {Spread{10}, Spread{10}, Spread{10}};
  Aid aid = plain_receiver(motion, 1, 0);
  aid.outages.clear(), aid.correlation = 30, aid.lever_arm_sigma = 0.5;
  const ErrorBudget b = aided_budget(motion, s, {aid, Aid{.kind = AidKind::vehicle}});
  ASSERT_TRUE(b.loss);
  EXPECT_NEAR(b.loss->begin, b.time.back() * 2 / 3, 1);  // the last third
  for (const std::size_t at : {std::size_t{3}, b.time.size() - 1})
    for (int q = 0; q < budget_quantities; ++q) EXPECT_NEAR(b.shares(q, at).back(), 0, 1e-6) << "quantity " << q;
  const double with = std::sqrt(b.covariance[3](east, east));
  EXPECT_LT(with, 2);
  EXPECT_GT(std::sqrt(b.covariance.back()(east, east)), with);
}

TEST(AidedBudget, NamesOnceEachSourceWithoutAState) {
  ErrorSources s = no_errors();
  EXPECT_EQ(beyond_aided_budget(s), "");
  for (const char* name : {"gyro.offset.x", "gyro.quadratic.x", "gyro.quadratic.y", "accel.cubic.z"})
    s.coefficients.push_back(coefficient_index(name));
  s.fixed = Eigen::VectorXd::Constant(4, 1e-3);
  s.covariance = Eigen::MatrixXd::Zero(4, 4);
  s.gyro_noise.Q = 1e-6;
  EXPECT_EQ(beyond_aided_budget(s), "gyro nonlinearity, accelerometer nonlinearity, gyro quantization");
}

TEST(AidedBudget, OnlyAnAidThatMeasuresCanBeLost) {
  const NominalMotion motion = resting(30);
  try {
    aided_budget(motion, no_errors(), {Aid{.kind = AidKind::vehicle}});
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("cannot be lost"));
  }
}

}  // namespace
}  // namespace imulab
