#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/closed_form_flight.hpp"
#include <limits>

namespace imulab {
namespace {

using namespace motion;

using Eigen::Quaterniond;

NavigationState integrated(const Trajectory& truth, double interval, std::size_t samples) {
  const std::vector<Increment> increments = ideal_increments(truth, interval);
  Strapdown strapdown(navigation_state(truth.at(0)));
  for (std::size_t i = 0; i + samples <= increments.size(); i += samples)
    strapdown.step(std::span(increments).subspan(i, samples), static_cast<double>(samples) * interval);
  return strapdown.state();
}

/// East, north, up [m].
Vector3d position_error(const NavigationState& a, const Kinematics& b) {
  const LocalEarth earth = local_earth(b.latitude, b.height);
  return {(a.longitude - b.longitude) * earth.transverse_radius * earth.cos_latitude, (a.latitude - b.latitude) * earth.meridian_radius,
          a.height - b.height};
}

TEST(Strapdown, AnHourOfFlightEndsWithinAMillimetre) {
  const Trajectory truth = closed_form_flight(3600);
  const NavigationState end = integrated(truth, 0.01, 1);
  const Kinematics expected = truth.at(3600);
  EXPECT_LT(position_error(end, expected).cwiseAbs().maxCoeff(), 1e-3);  // required accuracy; the vertical channel amplifies by about 270
  EXPECT_LT((end.velocity - expected.velocity).norm(), 2e-6);            // a millimetre times the channel's 1/570 s
  // 1e-10 rad: the horizontal error over the Earth's radius.
  EXPECT_LT(rotation_log(expected.C_nb.transpose() * end.q_nb.toRotationMatrix()).norm(), 1e-10);
}

TEST(Strapdown, ItsErrorFallsWithTheOrderOfTheAlgorithm) {
  // Swings are three times as fast, so that the error of the algorithm is far above rounding. The product of one sample and the previous refers to
  // the middle between both, half an interval late, with an error of rate x its second derivative, T^4/24 a step: third order. 0.5 allows for other
  // terms at these rates.
  const Trajectory truth = closed_form_flight(600, 3);
  const auto error = [&](double interval, std::size_t n) { return position_error(integrated(truth, interval, n), truth.at(600)).norm(); };
  EXPECT_NEAR(std::log2(error(0.1, 1) / error(0.05, 1)), 3, 0.5);
}

/// Integrates 24 h at rest with fixed height and given start errors. Calls `see` every ten seconds with time, velocity and latitude error.
template <class See>
void rest_for_a_day(double latitude, const Vector3d& velocity_error, See see) {
  Kinematics k;
  k.latitude = latitude;
  const BodyMotion motion = body_motion(k);
  k.velocity = velocity_error;
  StrapdownOptions options;
  options.vertical = VerticalChannel::fixed;
  Strapdown strapdown(navigation_state(k), options);
  for (int i = 0; i <= 86400; ++i) {
    if (i % 10 == 0) see(static_cast<double>(i), strapdown.state());
    strapdown.step(Increment{motion.rate_ib_b, motion.force_b}, 1);
  }
}

TEST(Strapdown, AtRestAVelocityErrorSwingsAsSchulersAndFoucaultsPendulumDo) {
  // v = vE + i vN obeys, for position changes that are slow compared with a day, v' = -i 2 w v - W^2 integral v with w = w_ie sin L, W^2 = g/R: a
  // swing of frequency sqrt(W^2 + w^2) in a plane that turns clockwise at w. On the ellipsoid, R is RM in the north and RN in the east (0.7 % apart
  // at the equator, equal at the pole), and the rotation of the attitude at w_ie enters with (w_ie/W)^2 = 0.35 %. At 70 deg, the phase after 24 h (17
  // periods) is therefore uncertain by 17 * 2 pi * 0.1 % = 0.1 rad, the plane by some hundredths.
  const double latitude = 70 * unit::deg, speed = 0.1;
  const LocalEarth earth = local_earth(latitude, 0);
  const double g = earth.gravity.norm(), radius = (earth.meridian_radius + earth.transverse_radius) / 2;
  const double vertical = earth_rate * std::sin(latitude), swing = std::sqrt(g / radius + vertical * vertical);
  double last = 0, last_time = 0, rising = 0, first_rise = -1, plane_turn = 0;
  int rises = 0;
  rest_for_a_day(latitude, {0, speed, 0}, [&](double t, const NavigationState& s) {
    // Components along and across the plane that turns clockwise at w, from north.
    const double along = s.velocity.y() * std::cos(vertical * t) + s.velocity.x() * std::sin(vertical * t);
    const double across = s.velocity.x() * std::cos(vertical * t) - s.velocity.y() * std::sin(vertical * t);
    if (t > 0 && last < 0 && along >= 0) {
      rising = last_time + (t - last_time) * -last / (along - last);
      if (first_rise < 0) first_rise = rising;
      ++rises;
    }
    plane_turn = std::max(plane_turn, std::abs(across));
    last = along;
    last_time = t;
  });
  const double period = (rising - first_rise) / (rises - 1);
  EXPECT_NEAR(period, 2 * std::numbers::pi / swing, 0.002 * period);  // 84.4 min at the surface; 0.2 % for the two radii of the ellipsoid
  EXPECT_EQ(rises, 17);
  EXPECT_LT(plane_turn, 0.15 * speed);  // Foucault: the orders named above remain in the turning plane
}

TEST(Strapdown, AtRestTheSwingHasSchulersPeriodAtTheEquator) {
  // There the vertical Earth rate is zero, and the meridian swings alone: gravity over RM, with the north pole's 0.5 % of (w_ie/W)^2.
  double last = 0, sum = 0, first = -1, latest = 0;
  int rises = 0;
  rest_for_a_day(0, {0, 0.1, 0}, [&](double t, const NavigationState& s) {
    const double v = s.velocity.y();
    if (t > 0 && last < 0 && v >= 0) {
      latest = t - 10 * v / (v - last);
      if (first < 0) first = latest;
      ++rises;
    }
    last = v;
    sum += v;
  });
  const LocalEarth earth = local_earth(0, 0);
  const double schuler = 2 * std::numbers::pi * std::sqrt(earth.meridian_radius / earth.gravity.norm());
  EXPECT_NEAR((latest - first) / (rises - 1), schuler, 0.005 * schuler);
}

TEST(Strapdown, AFreeVerticalChannelDivergesAsItsClosedForm) {
  // h'' = k^2 h, with k^2 the decrease of gravity with height: h = h0 cosh(kt). 0.5 % allows for feedback of the horizontal channels through
  // Coriolis, up to (2 w_ie/k)^2 = 0.7 % of k^2.
  Kinematics k;
  k.latitude = 0.6;
  const BodyMotion motion = body_motion(k);
  const double fall = (local_earth(k.latitude, -500).gravity.norm() - local_earth(k.latitude, 500).gravity.norm()) / 1000;
  k.height = 1;
  Strapdown strapdown(navigation_state(k));
  for (int i = 0; i < 1800; ++i) strapdown.step(Increment{motion.rate_ib_b, motion.force_b}, 1);
  const double expected = std::cosh(std::sqrt(fall) * 1800);
  EXPECT_NEAR(strapdown.state().height, expected, 5e-3 * expected);
}

TEST(Strapdown, AFixedVerticalChannelKeepsItsHeight) {
  Kinematics k;
  k.height = 123;
  k.velocity = {10, 20, 30};
  Strapdown strapdown(navigation_state(k), {.vertical = VerticalChannel::fixed});
  for (int i = 0; i < 100; ++i) strapdown.step(Increment{{0, 0, 0}, {0, 0, 5}}, 1);
  EXPECT_EQ(strapdown.state().height, 123);
  EXPECT_EQ(strapdown.state().velocity.z(), 0);
}

TEST(Strapdown, AnAidedVerticalChannelFollowsTheBarometerAndFindsTheBias) {
  // Three poles at -1/T: a step e of the height decays as e (1 - s + ... ) exp(-s), s = t/T; 1e-6 of it remains after twenty T, also for a biased
  // accelerometer.
  Kinematics k;
  const BodyMotion motion = body_motion(k);
  k.height = 10;
  StrapdownOptions options;
  options.vertical = VerticalChannel::aided;
  options.barometer_time_constant = 30;
  Strapdown strapdown(navigation_state(k), options);
  const double interval = 0.1;
  for (int i = 0; i < 6000; ++i)
    strapdown.step(Increment{interval * motion.rate_ib_b, interval * (motion.force_b + Vector3d(0, 0, 1e-3))}, interval, 0.);
  EXPECT_NEAR(strapdown.state().height, 0, 1e-4);
  EXPECT_NEAR(strapdown.state().velocity.z(), 0, 1e-4 + interval * 1e-3);  // velocity due to the bias in one step, removed at its end
}

TEST(Strapdown, AHeldVerticalChannelHasTheBarometersHeightAndAFreeVelocity) {
  Kinematics k;
  const BodyMotion motion = body_motion(k);
  Strapdown strapdown(navigation_state(k), {.vertical = VerticalChannel::held});
  for (int i = 0; i < 100; ++i) strapdown.step(Increment{motion.rate_ib_b, motion.force_b + Vector3d(0, 0, 1e-3)}, 1, 5. + i);
  EXPECT_EQ(strapdown.state().height, 104);
  // A bias of 1e-3 for 100 s, and the decrease of gravity with height, 3.1e-6 s^-2 times the mean of 54.5 m; 1 % because that value is rounded.
  EXPECT_NEAR(strapdown.state().velocity.z(), 0.1 + 100 * 3.1e-6 * 54.5, 0.001);
}

TEST(Strapdown, AConstantGravityIsTakenStraightDown) {
  Strapdown strapdown({}, {.gravity = 9.8});
  strapdown.step(Increment{{0, 0, 0}, {0, 0, 0}}, 1);
  EXPECT_NEAR(strapdown.state().velocity.z(), -9.8, 1e-3);  // Coriolis
}

TEST(Strapdown, RefusesThePolesAndAStartThatIsNone) {
  NavigationState start;
  start.latitude = 90 * unit::deg;
  EXPECT_THROW(Strapdown{start}, Error);
  start.latitude = 89.8999 * unit::deg;
  start.velocity = {0, 300, 0};
  Strapdown north(start);
  EXPECT_THROW(for (int i = 0; i < 100; ++i) north.step(Increment{{0, 0, 0}, {0, 0, 9.8}}, 1), Error);
  start.latitude = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Strapdown{start}, Error);
  start = {};
  start.q_nb = Quaterniond(2, 0, 0, 0);
  EXPECT_THROW(Strapdown{start}, Error);
  EXPECT_THROW(Strapdown({}, {.barometer_time_constant = 0}), Error);
  EXPECT_THROW(Strapdown({}, {.latitude_limit = 2}), Error);
  Strapdown backward{NavigationState{}};
  EXPECT_THROW(backward.step(Increment{}, 0), Error);
  EXPECT_THROW(backward.step(Increment{}, -0.01), Error);
}

}  // namespace
}  // namespace imulab
