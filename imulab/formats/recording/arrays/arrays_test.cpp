#include "imulab/formats/recording/arrays/arrays.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

namespace imulab::recording_io {
namespace {

TEST(Arrays, ASamplingRateIsReadBesideATable) {
  const std::vector<NumberArray> arrays{
      {"imu/acc", 100, column_names("imu/acc", 3)}, {"imu/fs", 1, column_names("imu/fs", 1)}, {"imu/unit", 1, column_names("imu/unit", 1)}};
  const std::vector<TableDescription> tables = descriptions_of(arrays);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables.front().columns.size(), 3u);
  EXPECT_THAT(tables.front().other_names, testing::ElementsAre("imu/acc", "imu/fs"));
  const std::vector<ArrayColumn> places = find_array_columns(arrays, "imu/fs", {1}, "file");
  ASSERT_EQ(places.size(), 1u);
  EXPECT_EQ(places.front().array, 1u);
  EXPECT_THROW(find_array_columns(arrays, "imu/unit", {1}, "file"), Error);
  for (const char* name : {"fs", "Sampling_Rate", "imu.sample_rate_hz", "/data/samplingFrequency"}) EXPECT_TRUE(names_rate(name)) << name;
  for (const char* name : {"rate", "fsr", "gyro_rate", ""}) EXPECT_FALSE(names_rate(name)) << name;
}

}  // namespace
}  // namespace imulab::recording_io
