#include "imulab/recording/overview.hpp"

#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace imulab {
namespace {

Recording recording_of(std::size_t n) {
  Recording r;
  r.interval_s = 0.01;
  r.gyro_unit = "rad/s", r.accel_unit = "m/s^2";
  for (std::size_t i = 0; i < n; ++i) {
    r.time_ns.push_back(static_cast<std::int64_t>(i) * 10'000'000);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      r.gyro[axis].push_back(static_cast<double>(i % 7));
      r.accel[axis].push_back(static_cast<double>(axis));
    }
  }
  return r;
}

TEST(Overview, AShortRecordingIsShownSampleBySample) {
  const Overview o = overview(SensorModel{}, recording_of(100), 50);
  EXPECT_EQ(o.samples_per_interval, 1u);
  EXPECT_EQ(o.time.size(), 100u);
  EXPECT_EQ(o.rate[2][8], 1);
  EXPECT_EQ(o.force[1][8], 1);
}

TEST(Overview, NoSpikeIsLostInALongOne) {
  Recording r = recording_of(100'000);
  r.gyro[1][54'321] = 99;
  r.accel[2][98'765] = -99;
  const Overview o = overview(SensorModel{}, r, 200);
  EXPECT_EQ(o.samples_per_interval, 500u);
  EXPECT_EQ(o.first_s, r.time_s(0));
  ASSERT_EQ(o.time.size(), 400u);
  EXPECT_EQ(o.rate[1].size(), 400u);
  const auto spike = std::max_element(o.rate[1].begin(), o.rate[1].end());
  EXPECT_EQ(*spike, 99);
  EXPECT_NEAR(o.time[static_cast<std::size_t>(spike - o.rate[1].begin())], 543.21, 5);
  EXPECT_EQ(*std::min_element(o.force[2].begin(), o.force[2].end()), -99);
  EXPECT_TRUE(std::is_sorted(o.time.begin(), o.time.end()));
}

TEST(Overview, ExtremesKeepTheirOrder) {
  Recording r = recording_of(1000);
  for (std::size_t i = 0; i < 1000; ++i) r.gyro[0][i] = -static_cast<double>(i);  // falls
  const Overview o = overview(SensorModel{}, r, 10);
  EXPECT_TRUE(std::is_sorted(o.rate[0].rbegin(), o.rate[0].rend()));
}

TEST(Overview, ItIsCompensated) {
  SensorModel model;
  model.gyro.offset = {10, 0, 0};
  EXPECT_EQ(overview(model, recording_of(10), 50).rate[0][3], 13);
}

TEST(Overview, AnEmptyRecordingIsEmpty) { EXPECT_TRUE(overview(SensorModel{}, recording_of(0), 50).time.empty()); }

TEST(Overview, AMissingTemperatureIsRefused) {
  SensorModel model;
  model.accel.thermal(0, 1) = 1;
  model.accel.temperature = ThermalReading{};
  EXPECT_THROW(overview(model, recording_of(10), 50), Error);
}

}  // namespace
}  // namespace imulab
