#include "imulab/navigation/flight.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <GeographicLib/Ellipsoid.hpp>
#include <gtest/gtest.h>

namespace imulab {
namespace {

const FlightStart start{0.54, 1.82, 500, 80, 0};

const std::vector<Segment> pattern{straight(20),       turn(-90 * unit::deg, 2 * unit::deg, 4),  climb(5 * unit::deg, 20, 6),
                                   accelerate(30, 20), s_turn(30 * unit::deg, 2 * unit::deg, 4), climb(-5 * unit::deg, 10, 6)};

TEST(Flight, DerivativesAreThoseOfTheMotion) {
  const Trajectory f = flight(start, pattern);
  const double h = 1e-3;
  for (double t = 0.513; t < f.duration - 1; t += 0.731) {
    const Kinematics a = f.at(t - h), k = f.at(t), b = f.at(t + h);
    const LocalEarth earth = local_earth(k.latitude, k.height);
    const Eigen::Vector3d v((b.longitude - a.longitude) * earth.transverse_radius * earth.cos_latitude,
                            (b.latitude - a.latitude) * earth.meridian_radius, b.height - a.height);
    // Central differences: h^2 of the third derivative is below 1e-6 for all; rounding of an angle of 1.8 times the radius over h: 3e-6.
    EXPECT_LT((v / (2 * h) - k.velocity).norm(), 1e-5) << t;
    EXPECT_LT(((b.velocity - a.velocity) / (2 * h) - k.acceleration).norm(), 1e-5) << t;
    EXPECT_NEAR((b.angles.roll - a.angles.roll) / (2 * h), k.angle_rates.roll, 1e-6) << t;
    EXPECT_NEAR((b.angles.pitch - a.angles.pitch) / (2 * h), k.angle_rates.pitch, 1e-6) << t;
    EXPECT_NEAR((b.angles.heading - a.angles.heading) / (2 * h), k.angle_rates.heading, 1e-6) << t;
  }
}

TEST(Flight, DoesWhatItsSegmentsSay) {
  const Trajectory f = flight(start, pattern);
  const Kinematics turning = f.at(20 + 20), end = f.at(f.duration);
  EXPECT_NEAR(turning.angles.roll, std::atan(-80 * 2 * unit::deg / unit::g), 1e-12);  // rounding
  EXPECT_NEAR(end.angles.heading, -90 * unit::deg, 1e-12);
  EXPECT_NEAR(end.velocity.norm(), 110, 1e-10);
  EXPECT_NEAR(end.angles.roll, 0, 1e-12);
  EXPECT_NEAR(end.angles.pitch, 0, 1e-12);
}

TEST(Flight, NorthwardsItFollowsTheMeridian) {
  FlightStart ground = start;
  ground.height = 0;
  const Kinematics end = flight(ground, {straight(600)}).at(600);
  const auto& ellipsoid = GeographicLib::Ellipsoid::WGS84();
  const double arc = ellipsoid.MeridianDistance(end.latitude / unit::deg) - ellipsoid.MeridianDistance(ground.latitude / unit::deg);
  EXPECT_NEAR(arc, 80 * 600, 1e-6);  // a thousand roundings of the Earth's radius, 1e-9 m each
}

TEST(Flight, ACoordinatedTurnPushesThePilotIntoTheSeat) {
  // Across the body nothing is felt but gravity's difference from the nominal g, and Coriolis: below 2 % of g, times the bank's sine.
  const BodyMotion motion = body_motion(flight(start, pattern).at(40));
  EXPECT_LT(std::abs(motion.force_b.x()), 0.02 * unit::g);
  EXPECT_GT(motion.force_b.z(), unit::g);
}

TEST(Flight, IntegratedItComesBack) {
  const Trajectory f = flight(start, pattern);
  Strapdown strapdown(navigation_state(f.at(0)));
  for (const Increment& sample : ideal_increments(f, 0.01)) strapdown.step(sample, 0.01);
  const Kinematics end = f.at(std::floor(f.duration * 100) / 100);
  EXPECT_NEAR(strapdown.state().height, end.height, 1e-3);  // the accuracy asked of an hour's flight
  EXPECT_NEAR(strapdown.state().latitude, end.latitude, 1e-3 / 6.4e6);
  EXPECT_NEAR(strapdown.state().longitude, end.longitude, 1e-3 / 5.4e6);
}

TEST(Flight, RefusesATurnThatEndsBeforeItHasRolledIn) {
  EXPECT_THROW(turn(5 * unit::deg, 2 * unit::deg, 4), Error);
  EXPECT_THROW(turn(5 * unit::deg, 0, 4), Error);
  EXPECT_THROW(flight(start, {straight(0)}), Error);
  EXPECT_THROW(flight(start, {}), Error);
}

}  // namespace
}  // namespace imulab
