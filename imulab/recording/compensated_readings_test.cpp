#include "imulab/recording/compensated_readings.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

Recording long_thermal_recording(std::size_t n) {
  Recording r;
  r.name = "long.csv";
  r.interval_s = 0.01;
  for (std::size_t i = 0; i < n; ++i) {
    r.time_ns.push_back(static_cast<std::int64_t>(i) * 10'000'000);
    for (std::size_t k = 0; k < 3; ++k) {
      r.gyro[k].push_back(RandomStream(7, k).normal(i));
      r.accel[k].push_back(RandomStream(7, 3 + k).normal(i));
      r.accel_temperature[k].push_back(20 + 1e-3 * static_cast<double>(i));
    }
  }
  return r;
}

SensorModel thermal_model() {
  SensorModel m;
  m.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  m.accel.thermal.col(1) = Vector3d(1e-3, 2e-3, -1e-3);
  m.g_sensitivity(0, 1) = 1e-3;
  return m;
}

TEST(CompensatedReadings, AreThoseOfTheWholeRecording) {
  const Recording raw = long_thermal_recording(2500);
  const SensorModel model = thermal_model();
  const Recording whole = compensate(model, raw).recording;
  CompensatedReadings readings(raw, model);
  const auto expect_same = [&](std::size_t i) {
    EXPECT_EQ(readings.rate(i), reading_at(whole.gyro, i)) << i;
    EXPECT_EQ(readings.force(i), reading_at(whole.accel, i)) << i;
  };
  for (std::size_t i = 0; i < raw.size(); ++i)  // with the neighbors that differences need
    for (const std::size_t near : {i, i > 0 ? i - 1 : i, std::min(i + 2, raw.size() - 1)}) expect_same(near);
  for (const std::size_t far : {3u, 2499u, 1200u, 0u}) expect_same(far);
}

TEST(CompensatedReadings, RefuseWhatHasNoFiniteCompensation) {
  Recording raw = long_thermal_recording(2000);
  raw.gyro[1][1500] = 1e308;
  SensorModel model = thermal_model();
  model.gyro.matrix(1, 1) = 100;
  CompensatedReadings readings(raw, model);
  EXPECT_NO_THROW(readings.rate(400));
  try {
    readings.rate(1499);
    FAIL();
  } catch (const std::exception& e) {
    EXPECT_STREQ(e.what(), "long.csv: the sample at 15.000000 s has a reading that no compensation makes finite");
  }
}

}  // namespace
}  // namespace imulab
