#include "imulab/simulate/simulate_motion.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/compensate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

TEST(SimulateMotion, CompensationGivesTheMotionBackButForTheNoise) {
  Truth unit;
  unit.model.accel.offset = {0.1, -0.2, 0.3};
  unit.model.accel.matrix << 1.01, 0, 0, 0.02, 0.99, 0, -0.01, 0.03, 1.02;
  unit.model.accel.quadratic = {1e-4, 2e-4, -1e-4};
  unit.model.gyro.offset = {1e-3, 2e-3, -1e-3};
  unit.model.gyro.matrix << 0.5, 0.01, 0, 0, 0.52, 0.01, 0.02, 0, 0.49;
  unit.model.g_sensitivity.setConstant(1e-4);
  unit.gyro_noise.N = 1e-4;
  const std::size_t n = 4000;
  const double interval = 0.01;
  const std::vector<Increment> ideal(n, {interval * Vector3d(0.1, -0.2, 0.3), interval * Vector3d(1, 2, 9.8)});
  const Recording r = simulate_motion(ideal, interval, unit, 1);
  ASSERT_EQ(r.size(), n);
  EXPECT_EQ(r.time_ns.back(), 40'000'000'000);
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Motion m = compensate(unit.model, {{r.accel[0][i], r.accel[1][i], r.accel[2][i]}, {r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]}});
    EXPECT_LT((m.force - Vector3d(1, 2, 9.8)).norm(), 1e-12);  // no noise of its own; rounding
    sum += m.rate.x() - 0.1;
    square += (m.rate.x() - 0.1) * (m.rate.x() - 0.1);
  }
  const double sigma = unit.gyro_noise.N / std::sqrt(interval);
  EXPECT_LT(std::abs(sum / n), 5 * sigma / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(square / n), sigma, 5 * sigma / std::sqrt(2. * n));
  EXPECT_EQ(simulate_motion(ideal, interval, unit, 1).gyro, r.gyro);
  EXPECT_NE(simulate_motion(ideal, interval, unit, 2).gyro, r.gyro);
}

TEST(SimulateMotion, RefusesWhatAMotionDoesNotTell) {
  Truth unit;
  unit.model.lever_arm(0, 1) = 0.1;
  EXPECT_THROW(simulate_motion({{}}, 0.01, unit, 1), Error);
  Truth warm;
  warm.model.gyro.thermal(0, 1) = 1;
  EXPECT_THROW(simulate_motion({{}}, 0.01, warm, 1), Error);
}

}  // namespace
}  // namespace imulab
