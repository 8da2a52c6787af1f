#include "imulab/estimate/hybrid/latitude_at_rest.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab::hybrid {
namespace {

constexpr double gravity = 9.8, rest_s = 20;

/// Returns rests in random attitudes of an ideal unit with a gyro offset of 100 deg/h and white noise [rad/s/sqrt(Hz)].
std::vector<RestMeans> rests_at(double latitude, std::size_t count, double noise, std::uint64_t seed) {
  const RandomStream draws(seed, "latitude at rest");
  std::uint64_t next = 0;
  const auto normal = [&] { return Vector3d(draws.normal(next), draws.normal(next + 1), draws.normal(next + 2)); };
  std::vector<RestMeans> rests;
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d up = (next += 3, normal().normalized()), any = (next += 3, normal());
    const Vector3d north = any.cross(up).normalized();
    const Vector3d rate = earth_rate * (std::sin(latitude) * up + std::cos(latitude) * north) + 100 * unit::deg_per_h * Vector3d(1, -1, 0.5);
    next += 3;
    const double begin = 25.0 * static_cast<double>(k);
    rests.push_back({{}, begin + rest_s / 2, gravity * up, rate + noise / std::sqrt(rest_s) * normal(), begin, begin + rest_s});
  }
  return rests;
}

GyrosAtRest gyros(double noise) { return {noise, 1e-6, 0, gravity}; }

TEST(LatitudeAtRest, ADeclaredOneThatIsRightIsNotContradicted) {
  const double noise = 0.001 * unit::deg_per_sqrt_h;
  for (const double latitude : {-89.0, -30.0, 0.0, 45.0, 80.0, 90.0})
    for (std::uint64_t seed = 1; seed <= 200; ++seed)
      EXPECT_FALSE(latitude_against(latitude * unit::deg, 0, rests_at(latitude * unit::deg, 24, noise, seed), {}, gyros(noise))) << latitude;
}

TEST(LatitudeAtRest, AnotherOneIsFoundWithinItsUncertainty) {
  const double noise = 0.001 * unit::deg_per_sqrt_h;
  for (const double latitude : {-70.0, 20.0, 45.0}) {
    double squares = 0;
    constexpr int sessions = 200;
    for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
      const auto seen = latitude_against((latitude + 1) * unit::deg, 0, rests_at(latitude * unit::deg, 24, noise, seed), {}, gyros(noise));
      ASSERT_TRUE(seen) << latitude << " " << seed;
      squares += std::pow((seen->value - latitude * unit::deg) / seen->sigma, 2);
    }
    EXPECT_GT(squares, 0.6 * sessions) << latitude << ": of scatter and noise the larger one counts, twice";
    EXPECT_LT(squares, chi_square_quantile(0.9995, sessions)) << latitude;
  }
}

TEST(LatitudeAtRest, TheHemisphereIsThatOfTheRateAlongGravityUnlessAGSensitivityMayBeAsLarge) {
  const double noise = 0.001 * unit::deg_per_sqrt_h;
  const std::vector<RestMeans> rests = rests_at(45 * unit::deg, 24, noise, 1);
  GyrosAtRest known = gyros(noise);
  const auto seen = latitude_against(-45 * unit::deg, 0, rests, {}, known);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->value, 45 * unit::deg, 5 * seen->sigma);
  known.g_sensitivity = 1e-3;
  EXPECT_FALSE(latitude_against(-45 * unit::deg, 0, rests, {}, known));
  EXPECT_TRUE(latitude_against(0, 0, rests, {}, known)) << "nor does the rate across gravity fit";
}

TEST(LatitudeAtRest, SaysNothingWhereTheRestsDoNot) {
  const double noise = 0.001 * unit::deg_per_sqrt_h;
  EXPECT_FALSE(latitude_against(0, 0, rests_at(45 * unit::deg, 7, noise, 1), {}, gyros(noise))) << "too few";
  std::vector<RestMeans> alike = rests_at(45 * unit::deg, 24, noise, 1);
  for (RestMeans& rest : alike) rest = alike.front();
  EXPECT_FALSE(latitude_against(0, 0, alike, {}, gyros(noise))) << "in one attitude";
  GyrosAtRest mems = gyros(1 * unit::deg_per_sqrt_h);
  mems.g_sensitivity = 1e-4;
  for (std::uint64_t seed = 1; seed <= 200; ++seed)
    ASSERT_FALSE(latitude_against(0, 0, rests_at(45 * unit::deg, 24, mems.noise, seed), {}, mems)) << "gyros that hardly measure the Earth's rate";
  EXPECT_FALSE(latitude_against(0, 20 * unit::deg, rests_at(45 * unit::deg, 24, noise, 1), {}, gyros(noise))) << "declared so uncertain";
  std::vector<RestMeans> drifting = rests_at(45 * unit::deg, 24, noise, 1);
  for (std::size_t k = 0; k < drifting.size(); ++k) drifting[k].gyro.x() += 5 * unit::deg_per_h * std::sin(0.3 * static_cast<double>(k));
  EXPECT_FALSE(latitude_against(44 * unit::deg, 0, drifting, {}, gyros(noise))) << "a drift counts as noise";
}

}  // namespace
}  // namespace imulab::hybrid
