#include "imulab/navigation/navigation_error.hpp"

#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using namespace motion;

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Trajectory& motion() {
  static const Trajectory m = flight({45 * unit::deg, 0.1, 100, 50, 0.5}, {straight(5), turn(1.5, 0.1, 4), climb(0.1, 5, 3), straight(5)});
  return m;
}

Solution sampled(double begin, double end, double interval, double phase = 0) {
  Solution out;
  for (int i = 0; begin + i * interval + phase < end + 1e-9; ++i) {
    out.time.push_back(begin + i * interval + phase);
    out.states.push_back(navigation_state(motion().at(out.time.back())));
  }
  return out;
}

TEST(NavigationErrors, OfTheTruthItselfAreZeroBetweenItsStampsToo) {
  // The stamps at 10 Hz are in the middle between those at 100 Hz and at 10 Hz.
  for (const auto& [interval, position, velocity, attitude] : {std::tuple(0.01, 1e-6, 1e-6, 1e-5), std::tuple(0.1, 1e-4, 1e-3, 5e-4)}) {
    const NavigationErrors errors = navigation_errors(sampled(0, 20, interval), sampled(0, 20, 0.1, interval / 2));
    ASSERT_GT(errors.history.size(), 190u);
    for (const NavigationError& e : errors.history) {
      // h^4/384 of 1 m/s^4 and its derivative, both times some tens; h^2/8 of 0.2 rad/s^2 (the roll), twice
      EXPECT_LT(e.position.norm(), position) << e.time;
      EXPECT_LT(e.velocity.norm(), velocity) << e.time;
      EXPECT_LT(e.attitude.norm(), attitude) << e.time;
    }
    EXPECT_THAT(errors.warnings, IsEmpty());
  }
}

TEST(NavigationErrors, AreEastNorthUpWithTheConventionOfTheAttitudeError) {
  const Solution truth = sampled(0, 10, 0.1);
  Solution off = truth;
  const LocalEarth e = local_earth(truth.states.back().latitude, truth.states.back().height);
  NavigationState& last = off.states.back();
  last.longitude += 3 / (e.transverse_radius * e.cos_latitude) + 2 * std::numbers::pi;  // a full turn is no error
  last.latitude += 4 / e.meridian_radius;
  last.height += 5;
  last.velocity += Eigen::Vector3d(0.1, 0.2, 0.3);
  EulerAngles angles = euler_angles(last.q_nb.toRotationMatrix());
  angles.heading += 1e-3;
  last.q_nb = Eigen::Quaterniond(attitude_matrix(angles));
  const NavigationErrors errors = navigation_errors(off, truth);
  const NavigationError& end = errors.history.back();
  EXPECT_LT((end.position - Eigen::Vector3d(3, 4, 5)).norm(), 1e-5);
  EXPECT_LT((end.velocity - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((end.attitude - Eigen::Vector3d(0, 0, 1e-3)).norm(), 1e-9);
  EXPECT_NEAR(end.horizontal(), 5, 1e-5);
  EXPECT_NEAR(errors.rate, 0.5, 1e-6);  // 5 m in 10 s
  EXPECT_LT(errors.history[50].position.norm(), 1e-9);
}

TEST(NavigationErrors, AreThoseOfTheCommonTime) {
  const NavigationErrors part = navigation_errors(sampled(0, 20, 0.01), sampled(5, 15, 0.1));
  EXPECT_NEAR(part.history.front().time, 5, 1e-9);
  EXPECT_NEAR(part.history.back().time, 15, 1e-9);
  ASSERT_EQ(part.warnings.size(), 1u);
  EXPECT_THAT(part.warnings[0], HasSubstr("errors are known from 5.000 s to 15.000 s only"));
  try {
    navigation_errors(sampled(0, 5, 0.1), sampled(6, 8, 0.1));
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "the truth runs from 6.000 s to 8.000 s, the solution from 0.000 s to 5.000 s: expected times that overlap");
  }
}

TEST(ComparedStates, GiveTheErrorsThatAllStatesGive) {
  Solution all = sampled(0, 10, 0.01);
  for (NavigationState& s : all.states) s.height += 3, s.velocity.x() += 0.1;
  // The truth has its times on the stamps, between them, as dense, denser, longer at both ends, partial, or a single row.
  for (const Solution& truth : {sampled(0, 10, 0.5), sampled(0, 10, 0.5, 0.003), sampled(0, 10, 0.01), sampled(0, 10, 0.004), sampled(-1, 11, 0.5),
                                sampled(4, 6, 0.1), sampled(5, 5, 1), sampled(9.9, 12, 1)}) {
    ComparedStates some(truth);
    for (std::size_t i = 0; i < all.size(); ++i) some.add(all.time[i], all.states[i]);
    EXPECT_LE(some.solution().size(), std::min(all.size(), 2 * truth.size() + 3));
    const NavigationErrors expected = navigation_errors(all, truth), found = navigation_errors(some.solution(), truth);
    EXPECT_EQ(found.warnings, expected.warnings);
    EXPECT_EQ(found.rate, expected.rate);
    ASSERT_EQ(found.history.size(), expected.history.size());
    for (std::size_t i = 0; i < found.history.size(); ++i) {
      EXPECT_EQ(found.history[i].time, expected.history[i].time);
      EXPECT_EQ(found.history[i].position, expected.history[i].position);
      EXPECT_EQ(found.history[i].velocity, expected.history[i].velocity);
      EXPECT_EQ(found.history[i].attitude, expected.history[i].attitude);
    }
  }
}

TEST(NavigationErrors, OfASetAreSummedUp) {
  const RateSummary s = rate_summary({1, 2, 9});
  EXPECT_DOUBLE_EQ(s.cep, 2);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(86. / 3));
}

}  // namespace
}  // namespace imulab
