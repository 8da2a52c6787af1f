#include "imulab/earth.hpp"

#include "imulab/units.hpp"

#include <GeographicLib/Ellipsoid.hpp>
#include <GeographicLib/NormalGravity.hpp>
#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(Earth, GravityIsTheLevelEllipsoidsInBothComponents) {
  const auto& reference = GeographicLib::NormalGravity::WGS84();
  for (int latitude = -900; latitude <= 900; latitude += 7)
    for (double height : {-1e3, 0., 1., 500., 3e3, 1e4, 1.5e4, 3e4, 1e5}) {
      double north, up;
      reference.Gravity(0.1 * latitude, height, north, up);
      const auto gravity = local_earth(0.1 * latitude * unit::deg, height).gravity;
      EXPECT_EQ(gravity.x(), 0);
      // 1e-12 m/s^2 is stated by the interface; rounding of 9.8 in some ten operations is 1e-14.
      EXPECT_NEAR(gravity.y(), north, 1e-12) << latitude << " " << height;
      EXPECT_NEAR(gravity.z(), up, 1e-12) << latitude << " " << height;
      EXPECT_NEAR(normal_gravity(0.1 * latitude * unit::deg, height), std::hypot(north, up), 1e-12) << latitude << " " << height;
    }
  for (double latitude : {-90., 90.}) {
    double north, up;
    reference.Gravity(latitude, 100, north, up);
    EXPECT_NEAR(local_earth(latitude * unit::deg, 100).gravity.z(), up, 1e-12);
  }
}

TEST(Earth, RadiiAreThoseOfTheEllipsoid) {
  const auto& ellipsoid = GeographicLib::Ellipsoid::WGS84();
  for (double latitude : {-90., -33.3, 0., 10., 45., 89.}) {
    const auto earth = local_earth(latitude * unit::deg, 1234);
    // 1e-8 m is ten roundings of 6.4e6.
    EXPECT_NEAR(earth.meridian_radius, ellipsoid.MeridionalCurvatureRadius(latitude) + 1234, 1e-8);
    EXPECT_NEAR(earth.transverse_radius, ellipsoid.TransverseCurvatureRadius(latitude) + 1234, 1e-8);
  }
}

TEST(Earth, TransportRateTurnsTheVerticalAlongTheTrack) {
  const double latitude = 0.7;
  const auto earth = local_earth(latitude, 0);
  const Eigen::Vector3d north = earth.transport_rate({0, 100, 0}), east = earth.transport_rate({100, 0, 0});
  EXPECT_DOUBLE_EQ(north.x(), -100 / earth.meridian_radius);  // northward: the axes tilt about west
  EXPECT_EQ(north.tail<2>().norm(), 0);
  // Eastward: a rotation about the Earth's axis by the rate of the longitude. 1e-17: the rounding of 1.6e-5.
  const double longitude_rate = 100 / (earth.transverse_radius * std::cos(latitude));
  EXPECT_LT((east - longitude_rate * Eigen::Vector3d(0, std::cos(latitude), std::sin(latitude))).norm(), 1e-17);
  EXPECT_EQ(earth.rate, earth_rate_enu(latitude));
}

}  // namespace
}  // namespace imulab
