#include "imulab/compensate.hpp"
#include "imulab/error.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Recording three_samples() {
  Recording r;
  r.name = "recording.csv";
  r.interval_s = 0.01;
  r.time_ns = {0, 10'000'000, 20'000'000};
  r.gyro = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}};
  r.accel = {{{10, 20, 30}, {40, 50, 60}, {70, 80, 90}}};
  r.gyro_increment = true;
  r.saturated = {1};
  return r;
}

SensorModel any_model() {
  SensorModel m;
  m.accel.matrix << 0.1, 0.01, 0, 0, 0.2, 0, 0, 0, 0.3;
  m.gyro.matrix << 0.5, 0, 0.01, 0, 0.4, 0, 0, 0, 0.3;
  m.g_sensitivity(0, 0) = 0.001;
  return m;
}

TEST(CompensateRecording, GivesEverySampleAndKeepsTheRest) {
  const SensorModel m = any_model();
  const Recording raw = three_samples();
  const CompensatedRecording out = compensate(m, raw);
  for (std::size_t k = 0; k < 3; ++k) {
    const Motion motion = compensate(
        m, RawSample{.gyro = {raw.gyro[0][k], raw.gyro[1][k], raw.gyro[2][k]}, .accel = {raw.accel[0][k], raw.accel[1][k], raw.accel[2][k]}});
    for (int i = 0; i < 3; ++i) {
      EXPECT_DOUBLE_EQ(out.recording.gyro[static_cast<std::size_t>(i)][k], motion.rate(i));
      EXPECT_DOUBLE_EQ(out.recording.accel[static_cast<std::size_t>(i)][k], motion.force(i));
    }
  }
  EXPECT_EQ(out.recording.time_ns, raw.time_ns);
  EXPECT_EQ(out.recording.saturated, raw.saturated);
  EXPECT_TRUE(out.recording.gyro_increment);
  EXPECT_EQ(out.recording.gyro_unit, "rad/s");
  EXPECT_EQ(out.recording.accel_unit, "m/s^2");
  EXPECT_TRUE(out.out_of_range.empty());
}

TEST(CompensateRecording, NamesTheSamplesOutsideTheCalibratedTemperatures) {
  SensorModel m = any_model();
  m.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  m.gyro.temperature = ThermalReading{"degC", 25, {10, 40}};
  Recording r = three_samples();
  r.accel_temperature = {{{70, 70, 70}, {0, 0, 71}, {30, 30, 30}}};
  EXPECT_THAT(compensate(m, r).out_of_range, ElementsAre(2));
  r.gyro_temperature = {{{9.9, 10, 10}, {40, 40, 40}, {30, 30, 30}}};
  EXPECT_THAT(compensate(m, r).out_of_range, ElementsAre(0, 2));
}

TEST(CompensateRecording, ATemperatureTheModelNeedsIsAskedForByName) {
  SensorModel m = any_model();
  m.gyro.temperature = ThermalReading{"degC", 25, {0, 70}};
  EXPECT_NO_THROW(compensate(m, three_samples())) << "no thermal terms: no reading needed";
  m.gyro.thermal(1, 1) = 0.1;
  try {
    compensate(m, three_samples());
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), StartsWith("recording.csv: "));
    EXPECT_THAT(e.what(), HasSubstr("no gyro temperature"));
  }
}

TEST(CompensateRecording, RefusesReadingsInAnotherUnit) {
  SensorModel from_counts;
  from_counts.accel.raw_unit = "count";
  Recording recording;
  recording.name = "r.csv";
  recording.accel_unit = "m/s^2";
  try {
    compensate(from_counts, recording);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "r.csv: accel is in m/s^2, expected count, which the calibration was made from");
  }
  recording.name = recording.accel_unit = "";  // as one that was moved from has them
  EXPECT_THAT([&] { compensate(from_counts, recording); }, testing::ThrowsMessage<Error>(testing::StartsWith("recording: accel is in no unit, exp")));
}

}  // namespace
}  // namespace imulab
