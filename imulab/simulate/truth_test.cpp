// A drawn IMU with many coefficients.
#include "imulab/compensate.hpp"
#include "imulab/grade.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

using unit::deg;

TEST(Truth, AUnitFor30GHasThePapersCoefficients) {
  Session s;
  s.site.latitude = 40 * deg;
  s.imu.grade = "mems-30g";
  int negative = 0, draws = 0;
  // Dai 2011 table 2 in its own units: %, per deg/s, per g.
  const auto inside = [&](double value, double low, double high) {
    EXPECT_GE(std::abs(value), low * (1 - 1e-12));
    EXPECT_LE(std::abs(value), high * (1 + 1e-12));
    negative += value < 0, ++draws;
  };
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Truth truth = draw_truth(s, seed);
    EXPECT_EQ(truth.frame, BodyFrame::rig);
    const SensorModel& m = truth.model;
    for (int i = 0; i < 3; ++i) {
      inside(m.gyro.quadratic(i) * deg, 1.5e-4, 2.5e-4);
      inside(m.accel.quadratic(i) * unit::g, 2e-5, 1e-4);
      inside(m.gyro.cubic(i) * deg * deg, 4e-10, 1e-9);
      inside(m.accel.cubic(i) * unit::g * unit::g, 5e-6, 2e-5);
      for (int j = 0; j < 3; ++j) {
        inside(m.g_sensitivity(i, j) * unit::g / deg, 0.01, 0.04);
        if (i == j) continue;
        inside(m.gyro.matrix(i, j), 0.001, 0.005);
        inside(m.accel.matrix(i, j), 0.001, 0.02);
      }
    }
    // Full scale stays inside the ranges, along each axis, for either sign and any temperature.
    for (int i = 0; i < 3; ++i)
      for (const double sign : {-1.0, 1.0})
        for (const double tau : {-25.0, 45.0}) {
          Motion motion;
          motion.force(i) = sign * 30 * unit::g, motion.rate(i) = sign * 400 * deg;
          const RawSample raw = decompensate(m, motion, Vector3d::Constant(tau), Vector3d::Constant(tau));
          EXPECT_LT(raw.accel.cwiseAbs().maxCoeff(), grade("mems-30g").accel_noise.range);
          EXPECT_LT(raw.gyro.cwiseAbs().maxCoeff(), grade("mems-30g").gyro_noise.range);
        }
  }
  EXPECT_NEAR(negative, draws / 2.0, 5 * std::sqrt(draws / 4.0));  // five sigma of a fair coin
}

}  // namespace
}  // namespace imulab
