#include "imulab/simulate/simulate_motion.hpp"

#include "imulab/compensate.hpp"
#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

using namespace motion;

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
    const Motion m =
        compensate(unit.model, {.gyro = {r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]}, .accel = {r.accel[0][i], r.accel[1][i], r.accel[2][i]}});
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

/// Its gyros' thermal terms are in a resonance's units.
Truth thermal_unit() {
  Truth unit;
  unit.model.accel.thermal << 0, 1e-2, 1e-4, 0, 0, -2e-2, 0, 0, 0, 0, 3e-4, 0;
  unit.model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  unit.model.gyro.thermal << 0, 1e-3, 0, 0, 0, -2e-3, 1e-5, 0, 0, 3e-3, 0, 0;
  unit.model.gyro.temperature = ThermalReading{"raw", 5000, {4900, 5100}};
  return unit;
}

UnitTemperature warming() {
  UnitTemperature t{{0, 10}, {20, 60}, {}, {}};
  t.gyro.unit = "raw", t.gyro.at_25_degC = 5000, t.gyro.per_K = -1.5;
  return t;
}

TEST(SimulateMotion, ZerosDriftWithTheTemperature) {
  const double interval = 0.1;
  const std::vector<Increment> still(100, {Vector3d::Zero(), interval * Vector3d(0, 0, 9.8)});
  const Truth unit = thermal_unit();
  const Recording r = simulate_motion(still, interval, unit, 1, warming());
  // In the middle of the sample after t = 9.9 s: 59.8 degC, 34.8 K and -52.2 of the resonance from the references.
  EXPECT_NEAR(r.accel_temperature[0][99], 59.8, 1e-12);
  EXPECT_NEAR(r.gyro_temperature[2][99], 5000 - 52.2, 1e-9);
  EXPECT_NEAR(r.accel[0][99], 0.348 + 1e-4 * 34.8 * 34.8, 1e-12);
  EXPECT_NEAR(r.accel[1][99], -0.696, 1e-12);
  EXPECT_NEAR(r.accel[2][99], 9.8 + 3e-4 * 34.8 * 34.8, 1e-12);
  EXPECT_NEAR(r.gyro[1][99], 2e-3 * 52.2 + 1e-5 * 52.2 * 52.2, 1e-12);
  EXPECT_EQ(r.accel_temperature[0], r.accel_temperature[1]);
  EXPECT_LT(r.accel_temperature[0][0], r.accel_temperature[0][1]);
}

TEST(SimulateMotion, ThermalReadingsHaveNoiseOfTheirOwn) {
  const std::size_t n = 4000;
  const std::vector<Increment> still(n, {Vector3d::Zero(), 0.01 * Vector3d(0, 0, 9.8)});
  UnitTemperature noisy = warming();
  noisy.accel.noise = 0.5;
  const Truth unit = thermal_unit();
  const Recording exact = simulate_motion(still, 0.01, unit, 1, warming()), r = simulate_motion(still, 0.01, unit, 1, noisy);
  EXPECT_EQ(r.accel, exact.accel);  // the IMU follows its temperature, not the sensor's noise
  EXPECT_EQ(r.gyro_temperature, exact.gyro_temperature);
  double square = 0, product = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = r.accel_temperature[0][i] - exact.accel_temperature[0][i], y = r.accel_temperature[1][i] - exact.accel_temperature[1][i];
    square += x * x / n, product += x * y / n;
  }
  EXPECT_NEAR(std::sqrt(square), 0.5, 5 * 0.5 / std::sqrt(2. * n));  // five sigmas of each estimate
  EXPECT_LT(std::abs(product), 5 * 0.25 / std::sqrt(n));
}

TEST(SimulateMotion, RefusesWhatAMotionDoesNotTell) {
  Truth unit;
  unit.model.lever_arm(0, 1) = 0.1;
  EXPECT_THROW(simulate_motion({{}}, 0.01, unit, 1), Error);
  EXPECT_THROW(simulate_motion({{}}, 0.01, thermal_unit(), 1), Error);  // no temperature
  UnitTemperature celsius = warming();
  celsius.gyro.unit = "degC";
  EXPECT_THROW(simulate_motion({{}}, 0.01, thermal_unit(), 1, celsius), Error);
}

}  // namespace
}  // namespace imulab
