// Work that would take more memory than there is, or than is allowed, is refused before it begins.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(Memory, WhatWouldTakeMoreIsRefused) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure handheld --poses 12 -o p.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate p.toml -o s").exit_code, 0);  // 9600 rows: 0.54 MB as numbers
  for (const char* command : {"calibrate s --method static", "compensate s/truth.json s -o c.csv", "navigate none s"}) {
    const CommandResult refused = run_imulab(folder, std::string(command) + " --memory 0.5");
    EXPECT_EQ(refused.exit_code, 2) << command;
    EXPECT_THAT(on_one_line(refused.errors),
                testing::ContainsRegex("s/recording.csv: reading 0.00[0-9]* million rows of 7 columns takes about 0.000[0-9]* GB of memory"))
        << command;
    EXPECT_THAT(on_one_line(refused.errors), HasSubstr("; expected at most 0.0005 GB (--memory MB sets another limit)")) << command;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "c.csv"));
  EXPECT_EQ(run_imulab(folder, "inspect s/recording.csv --memory 1").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "inspect s/recording.csv --memory 2").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "compensate s/truth.json s -o c.csv --memory 1").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "calibrate s --method handheld -o c.json").exit_code, 0);
  const std::string navigate = "navigate c.json s --heading 0 --heading-sigma 1";
  EXPECT_THAT(on_one_line(run_imulab(folder, navigate + " --memory 0.7").errors), HasSubstr("a navigation takes about 0.00075"));
  for (const char* output : {"", " -o states.csv", " -o -", " --report r.html"})
    EXPECT_EQ(run_imulab(folder, navigate + output + " --memory 1").exit_code, 0) << output;
  const CommandResult explained = run_imulab(folder, navigate + " --json --memory 1");
  EXPECT_EQ(explained.exit_code, 0);
  EXPECT_THAT(explained.output, HasSubstr("\"explained\": {"));
  EXPECT_EQ(run_imulab(folder, "noise s --memory 0").exit_code, 2);
}

TEST(Memory, OfALogWithSeveralTopicsTheImuCounts) {
  const TemporaryFolder folder;
  for (const char* log : {"imu_none.mcap", "imu_none.bag", "imu.db3", "px4.ulg"}) {
    const std::string inspect = "inspect '" IMULAB_SOURCE "/tests/recordings/" + std::string(log) + "' --memory ";
    EXPECT_THAT(on_one_line(run_imulab(folder, inspect + "0.001").errors), HasSubstr("million rows of")) << log;
    EXPECT_EQ(run_imulab(folder, inspect + "1").errors, run_imulab(folder, inspect + "1000").errors) << log;
  }
}

}  // namespace
}  // namespace imulab
