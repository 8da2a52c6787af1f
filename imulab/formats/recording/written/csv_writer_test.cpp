#include "imulab/formats/recording/written/csv_writer.hpp"

#include "imulab/compensate.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <charconv>
#include <fstream>
#include <sstream>

namespace imulab {
namespace {

CompensatedRecording any_recording() {
  CompensatedRecording c;
  c.recording.interval_s = 0.25;
  c.recording.time_ns = {0, 250'000'000, 500'000'001};
  c.recording.gyro = {{{1, 2, 3}, {4, 5, 6}, {-7, 8, 1.0 / 3}}};
  c.recording.accel = {{{0.5, 1e-20, 2.5}, {1.5, 1, 1}, {9.8, 9.9, 9.7}}};
  return c;
}

std::string written(const CompensatedRecording& c) {
  const TemporaryFolder folder;
  write_compensated_rows(folder / "rows.csv", c);
  std::ostringstream text;
  text << std::ifstream(folder / "rows.csv").rdbuf();
  return text.str();
}

TEST(CsvWriter, IsTheTableAUserExpects) {
  EXPECT_EQ(written(any_recording()),
            "t,gx,gy,gz,ax,ay,az\n"
            "0,1,4,-7,0.5,1.5,9.8\n"
            "0.25,2,5,8,1e-20,1,9.9\n"
            "0.500000001,3,6,0.3333333333333333,2.5,1,9.7\n");
}

TEST(CsvWriter, IncrementsStayIncrements) {
  CompensatedRecording c = any_recording();
  c.recording.gyro_increment = true;
  EXPECT_THAT(written(c), ::testing::HasSubstr("\n0.25,0.5,1.25,2,1e-20,1,9.9\n"));
  c.recording.gyro_increment = false;
  c.recording.accel_increment = true;
  EXPECT_THAT(written(c), ::testing::HasSubstr("\n0.25,2,5,8,2.5e-21,0.25,2.475\n"));
}

TEST(CsvWriter, FlagsStandWhereSomeSampleHasOne) {
  CompensatedRecording c = any_recording();
  c.recording.saturated = {1, 2};
  c.out_of_range = {0, 2};
  EXPECT_EQ(written(c),
            "t,gx,gy,gz,ax,ay,az,flags\n"
            "0,1,4,-7,0.5,1.5,9.8,out_of_range\n"
            "0.25,2,5,8,1e-20,1,9.9,saturated\n"
            "0.500000001,3,6,0.3333333333333333,2.5,1,9.7,saturated|out_of_range\n");
}

TEST(CsvWriter, TheLongestNumbersFit) {
  CompensatedRecording c = any_recording();
  for (auto* triad : {&c.recording.gyro, &c.recording.accel})
    for (auto& column : *triad) column.assign(3, -2.2250738585072014e-308);
  c.recording.time_ns = {-9'223'372'036'854'775'807, 0, 9'223'372'036'854'775'807};
  const std::string text = written(c);
  EXPECT_THAT(text, ::testing::HasSubstr("-9223372036.854775807,-2.2250738585072014e-308,"));
}

}  // namespace
}  // namespace imulab
