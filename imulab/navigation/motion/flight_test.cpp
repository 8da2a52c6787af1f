#include "imulab/navigation/motion/flight.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"

#include <GeographicLib/Ellipsoid.hpp>
#include <gmock/gmock.h>

#include <numbers>

namespace imulab::motion {
namespace {

const FlightStart start{0.54, 1.82, 500, 80, 0};

const std::vector<Segment> pattern{straight(20),       turn(-90 * unit::deg, 2 * unit::deg, 4),  climb(5 * unit::deg, 20, 6),
                                   accelerate(30, 20), s_turn(30 * unit::deg, 2 * unit::deg, 4), climb(-5 * unit::deg, 10, 6)};

/// Compares derivatives with central differences of position, velocity and attitude. `pace`: factor by which third derivatives are larger.
void expect_derivatives(const Trajectory& f, double first, double step, double pace = 1) {
  const double h = 1e-3;
  for (double t = first; t < f.duration - h; t += step) {
    const Kinematics a = f.at(t - h), k = f.at(t), b = f.at(t + h);
    const LocalEarth earth = local_earth(k.latitude, k.height);
    const Eigen::Vector3d v((b.longitude - a.longitude) * earth.transverse_radius * earth.cos_latitude,
                            (b.latitude - a.latitude) * earth.meridian_radius, b.height - a.height);
    // Central differences: h^2 of the third derivative is below 1e-6 for all; rounding of an angle of 1.8 times the radius over h: 3e-6.
    EXPECT_LT((v / (2 * h) - k.velocity).norm(), 1e-5 * pace) << t;
    EXPECT_LT(((b.velocity - a.velocity) / (2 * h) - k.acceleration).norm(), 1e-5 * pace) << t;
    EXPECT_LT((rotation_log(a.C_nb.transpose() * b.C_nb) / (2 * h) - k.rate_nb_b).norm(), 1e-6 * pace) << t;
  }
}

TEST(Flight, DerivativesAreThoseOfTheMotion) { expect_derivatives(flight(start, pattern), 0.513, 0.731); }

TEST(Flight, DerivativesOfASwayAndOfATurningUnitAreThoseOfTheMotion) {
  FlightStart place = start;
  place.speed = 0;
  // For the sway, h^2/6 of the third derivative is 1e-6 w^3 / 6 of its amplitude: 3e-7 rad/s for 5 mrad at 1.1 Hz, 1.4e-7 m/s for 1 cm at 0.7 Hz.
  const Sway sway{0.005, 1.1, 0.01, 0.7};
  const std::vector<Segment> segments{
      rest(5, sway), rotate({0, 0.6, 0.8}, 2, 0.5), accelerate(10, 8), rotate({1, 0, 0}, -0.4, 0.2), turn(0.5, 0.2, 2), straight(1)};
  expect_derivatives(flight(place, segments), 0.0513, 0.0731);
}

TEST(Flight, DoesWhatItsSegmentsSay) {
  const Trajectory f = flight(start, pattern);
  const Kinematics turning = f.at(20 + 20), end = f.at(f.duration);
  EXPECT_NEAR(euler_angles(turning.C_nb).roll, std::atan(-80 * 2 * unit::deg / unit::g), 1e-12);  // rounding
  const EulerAngles angles = euler_angles(end.C_nb);
  EXPECT_NEAR(angles.heading, -90 * unit::deg, 1e-12);
  EXPECT_NEAR(end.velocity.norm(), 110, 1e-10);
  EXPECT_NEAR(angles.roll, 0, 1e-12);
  EXPECT_NEAR(angles.pitch, 0, 1e-12);
}

TEST(Flight, NorthwardsItFollowsTheMeridian) {
  FlightStart ground = start;
  ground.height = 0;
  const Kinematics end = flight(ground, {straight(600)}).at(600);
  const auto& ellipsoid = GeographicLib::Ellipsoid::WGS84();
  const double arc = ellipsoid.MeridianDistance(end.latitude / unit::deg) - ellipsoid.MeridianDistance(ground.latitude / unit::deg);
  EXPECT_NEAR(arc, 80 * 600, 1e-6);  // a thousand rounding errors of the Earth's radius, 1e-9 m each
}

TEST(Flight, ACoordinatedTurnPushesThePilotIntoTheSeat) {
  // The force across the body is only the difference of gravity from nominal g, and Coriolis: below 2 % of g, times the sine of the bank.
  const BodyMotion motion = body_motion(flight(start, pattern).at(40));
  EXPECT_LT(std::abs(motion.force_b.x()), 0.02 * unit::g);
  EXPECT_GT(motion.force_b.z(), unit::g);
}

/// Returns the error east, north, up [m] at the end of a free strapdown run on the ideal increments.
Eigen::Vector3d strapdown_error(const Trajectory& f, double interval) {
  Strapdown strapdown(navigation_state(f.at(0)));
  for (const Increment& sample : ideal_increments(f, interval)) strapdown.step(sample, interval);
  const NavigationState expected = truth(f, interval).states.back(), &end = strapdown.state();
  const LocalEarth earth = local_earth(expected.latitude, expected.height);
  return {(end.longitude - expected.longitude) * earth.transverse_radius * earth.cos_latitude,
          (end.latitude - expected.latitude) * earth.meridian_radius, end.height - expected.height};
}

TEST(Flight, IntegratedItComesBack) { EXPECT_LT(strapdown_error(flight(start, pattern), 0.01).norm(), 1e-3); }  // as an hour's flight

TEST(Flight, EveryKindOfSegmentComesBack) {
  FlightStart place = start;
  place.speed = 0;
  const Segment swaying = rest(20, {0.1 * unit::deg, 2, 2e-3, 5});
  const std::vector<Segment> all{swaying,
                                 rotate({0, 0, 1}, 180 * unit::deg, 10 * unit::deg),
                                 accelerate(40, 20),
                                 straight(10),
                                 turn(90 * unit::deg, turning_rate(400, 40), 3),
                                 s_turn(30 * unit::deg, 4 * unit::deg, 3),
                                 climb(0.1, 10, 4),
                                 rotate({1, 0, 0}, -90 * unit::deg, 20 * unit::deg),
                                 climb(-0.1, 10, 4),
                                 accelerate(-40, 20),
                                 rest(10)};
  // The sway is a coning motion: integration of one sample and the previous has a drift of 4th order in the interval and 2nd in the amplitude, 0.0012
  // deg/h / 25 here. Over 20 s, gravity converts it to 9.8 m/s^2 4.5e-9 rad (160 s)^2 / 2 = 0.6 mm.
  const Trajectory motion = flight(place, all);
  EXPECT_LT(strapdown_error(motion, 0.01).norm(), 1e-3);
  EXPECT_NEAR(std::log2(strapdown_error(motion, 0.02).norm() / strapdown_error(motion, 0.01).norm()), 4, 0.5);
}

/// A launch from a rail: a motor, and rolling, turning and bending down while it still pushes.
std::vector<Segment> launch() {
  const Segment motor = accelerate(1000, 5);
  const Segment rolling = together(motor, rotate({0, 1, 0}, 1200 * unit::deg, 400 * unit::deg), 0.5);
  const Segment turning = together(rolling, turn(20 * unit::deg, 8 * unit::deg, 1), 2.5);
  return {together(turning, pitch(-10 * unit::deg, 5 * unit::deg, 0.5), 3), straight(20)};
}

const FlightStart rail{.latitude = 0.7, .longitude = 1.7, .height = 1200, .heading = 0.5, .climb = 45 * unit::deg};
const Carrier missile{.banks = false, .lateral_limit = 200};

TEST(Flight, SegmentsAtTheSameTimeAddUp) {
  const Trajectory f = flight(rail, launch(), missile);
  EXPECT_NEAR(f.duration, 2.5 + 20. / 8 + 1 + 20, 1e-12);  // the turn ends last
  const Kinematics begin = f.at(0), rolling = f.at(2.5), end = f.at(f.duration);
  EXPECT_NEAR(euler_angles(begin.C_nb).pitch, 45 * unit::deg, 1e-12);  // rounding, as below
  EXPECT_NEAR(euler_angles(begin.C_nb).heading, 0.5, 1e-12);
  EXPECT_NEAR(rolling.rate_nb_b.y(), 400 * unit::deg, 1e-12);
  EXPECT_NEAR(end.velocity.norm(), 1000, 1e-10);
  EXPECT_NEAR(std::asin(end.velocity.z() / 1000), 35 * unit::deg, 1e-12);
  const Matrix3d expected = attitude_matrix({0, 35 * unit::deg, 0.5 + 20 * unit::deg}) * rotation_exp(Vector3d(0, 1200 * unit::deg, 0));
  EXPECT_LT((end.C_nb - expected).norm(), 1e-12);
  // The motor's full force along the rail, 1000 m/s over three quarters of 5 s, plus the support of the weight.
  EXPECT_NEAR(body_motion(f.at(2)).force_b.y(), 1000 / 3.75 + unit::g * std::sin(45 * unit::deg), 0.02);
}

TEST(Flight, AtThirtyGAndFourHundredDegreesASecondItComesBack) {
  // h^2/6 of the third derivatives: 87 m/s^2 due to pitching develop within 0.5 s, so the second derivative of the acceleration is 6 x 87 / 0.25
  // m/s^4, which gives 3.5e-4 m/s^2. For the roll it is 6 x 7 rad/s^3: 7e-6 rad/s.
  expect_derivatives(flight(rail, launch(), missile), 0.0513, 0.0731, 40);
  EXPECT_LT(strapdown_error(flight(rail, launch(), missile), 0.005).norm(), 0.01);  // compared with tens of meters due to noise
}

TEST(Flight, RefusesWhatDoesNotGoTogether) {
  EXPECT_THROW(together(rest(5), rotate({0, 1, 0}, 1, 1), 0), Error);
  EXPECT_THROW(together(straight(5), rest(5), 0), Error);
  EXPECT_THROW(together(straight(5), straight(5), -1), Error);
  EXPECT_THROW(together(rotate({0, 1, 0}, 1, 1), rotate({1, 0, 0}, 1, 1), 0), Error);
  EXPECT_THROW(pitch(5 * unit::deg, 10 * unit::deg, 1), Error);
}

TEST(Flight, ARotatedUnitStaysTurned) {
  FlightStart place = start;
  place.speed = 0;
  place.heading = 0.3;
  const Kinematics end = flight(place, {rotate({0, 0, 1}, 1.2, 0.5), rest(1), rotate({1, 0, 0}, -0.4, 0.5), rest(1)}).at(8);
  const Matrix3d expected = attitude_matrix({0, 0, 0.3}) * rotation_exp({0, 0, 1.2}) * rotation_exp({-0.4, 0, 0});
  EXPECT_LT((end.C_nb - expected).norm(), 1e-14);  // rounding
  EXPECT_EQ(end.velocity.norm(), 0);
}

TEST(Flight, AFastRotationWithinASampleIsIntegrated) {
  // Twenty turns per sample are about a level axis, east: gravity rotates, and cancels over whole turns.
  FlightStart place = start;
  place.speed = 0;
  place.latitude = 0;
  const double rate = 20 * 2 * std::numbers::pi * 100;
  const auto increments = ideal_increments(flight(place, {rotate(Vector3d(1, 0, 0), 4 * rate, rate)}), 0.01);
  EXPECT_NEAR(increments[200].angle.x(), 0.01 * rate, 1e-9);
  EXPECT_LT(increments[200].velocity.norm(), 1e-6);  // 0.1 m/s of gravity, to 1e-5
}

TEST(Flight, AVehicleTurnsWithoutBanking) {
  FlightStart road = start;
  road.speed = 15;
  const Trajectory drive = flight(road, {turn(90 * unit::deg, 0.2, 1), accelerate(-15, 6), rest(5), accelerate(15, 6)}, {.banks = false});
  for (double t = 0; t < drive.duration; t += 0.37) EXPECT_EQ(euler_angles(drive.at(t).C_nb).roll, 0);
  // Across the path, the wheels exert V heading' = 3 m/s^2 plus the Coriolis acceleration, below 0.005.
  EXPECT_NEAR(body_motion(drive.at(5)).force_b.x(), 3, 0.005);
  EXPECT_NEAR(drive.at(18).velocity.norm(), 0, 1e-12);
  EXPECT_NEAR(drive.at(drive.duration).velocity.x(), 15, 1e-12);  // eastwards
}

TEST(Flight, ASwayingBaseKeepsToItsAmplitudes) {
  FlightStart place = start;
  place.speed = 0;
  const Trajectory base = flight(place, {rest(10, {0.01, 3, 0.002, 7})});
  double angle = 0, way = 0;
  for (double t = 0; t <= 10; t += 0.0113) {
    angle = std::max(angle, std::abs(euler_angles(base.at(t).C_nb).pitch));
    way = std::max(way, std::abs(base.at(t).height - 500));
  }
  EXPECT_NEAR(angle, 0.01, 1e-4);  // the largest of some thousand instants
  EXPECT_NEAR(way, 0.002, 2e-5);
  EXPECT_EQ(base.at(0).velocity.norm(), 0);
  EXPECT_LT(base.at(10).velocity.norm(), 1e-12);
}

std::string refusal(const FlightStart& from, const std::vector<Segment>& segments, const Carrier& carrier = {}) {
  try {
    flight(from, segments, carrier);
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing";
}

TEST(Flight, RefusesATurnTighterThanTheSpeedAllows) {
  using ::testing::HasSubstr;
  // tan 60 deg = 1.732; at 80 m/s, 12.165 deg/s and a radius of 376.8 m.
  EXPECT_THAT(refusal(start, {straight(1), turn(1.5, 13 * unit::deg, 2)}),
              HasSubstr("segment 2: turn of 13.000 deg/s at 80.00 m/s: needs a bank of 61.6 deg, expected at most 60 deg; the tightest turn at this "
                        "speed is 12.165 deg/s, a radius of 376.8 m"));
  EXPECT_EQ(refusal(start, {turn(1.5, 12 * unit::deg, 2)}), "nothing");
  EXPECT_THAT(refusal(start, {turn(1.5, 4 * unit::deg, 2)}, {.banks = false}),
              HasSubstr("needs 5.59 m/s^2 across its path, expected at most 4 m/s^2"));
  EXPECT_THROW(turning_rate(100, 0), Error);
  EXPECT_THROW(turning_rate(0, 10), Error);
}

TEST(Flight, RefusesWhatIsNoMotion) {
  using ::testing::HasSubstr;
  EXPECT_THROW(turn(5 * unit::deg, 2 * unit::deg, 4), Error);
  EXPECT_THROW(turn(5 * unit::deg, 0, 4), Error);
  EXPECT_THROW(rotate({0, 0, 1}, 0, 1), Error);
  EXPECT_THROW(rotate({0, 0, 2}, 1, 1), Error);
  EXPECT_THROW(flight(start, {straight(0)}), Error);
  EXPECT_THROW(flight(start, {}), Error);
  EXPECT_THAT(refusal(start, {rest(5)}), HasSubstr("rest at 80.000 m/s: expected standstill"));
  EXPECT_THAT(refusal(start, {accelerate(-81, 5)}), HasSubstr("the speed would end at -1.000 m/s"));
  FlightStart north = start;
  north.latitude = 89.8 * unit::deg;
  EXPECT_THAT(refusal(north, {straight(1000)}), HasSubstr("segment 1: latitude 89.9"));
  north.latitude = std::numbers::pi / 2;
  EXPECT_THAT(refusal(north, {straight(1)}), HasSubstr("latitude 90.000000 deg: expected at most"));
}

}  // namespace
}  // namespace imulab::motion
