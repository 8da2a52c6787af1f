// `imulab live` on a drive as a driver uses it: a pipe of readings, and a receiver's file that grows beside it.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <string>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

/// Sessions `drive`, with circles in both directions, and `parked`; of a MEMS unit that is not known.
const TemporaryFolder& drives() {
  static const TemporaryFolder made;
  static const bool simulated = [] {
    const std::string head = R"(format = "imulab.mission/1"
rate_hz = 25
truth_rate_hz = 1
carrier = "vehicle"
[start]
latitude_deg = 48.1
longitude_deg = 11.6
height_m = 520
[errors]
grade = "mems"
[[aid]]
kind = "gnss"
lever_arm_m = [0.1, 0.5, 1.0]
position_sigma_m = 1
velocity_sigma_mps = 0.05
[[segment]]
kind = "rest"
duration_s = 20
)";
    std::string circles;
    for (const char* segment : {"accelerate\"\nto_mps = 8\nduration_s = 5", "turn\"\nangle_deg = 360\nrate_dps = 22",
                                "turn\"\nangle_deg = -360\nrate_dps = 22", "brake\"\nduration_s = 4"})
      circles += std::string("[[segment]]\nkind = \"") + segment + "\n";
    made.write("drive.toml", head + circles + circles);
    made.write("parked.toml", head + "[[segment]]\nkind = \"rest\"\nduration_s = 40\n");
    for (const char* name : {"drive", "parked"})
      run_shell(made, "'" + command_path() + "' trajectory " + name + ".toml --errors -o " + name + " && sed -i '/^\\[initial\\]/,/^heading/d' " +
                          name + "/session.toml && cp " + name + "/gnss_1.csv " + name + "/whole.csv");
    return true;
  }();
  (void)simulated;
  return made;
}

/// The commands' output into `imulab live - --session SESSION --method drive ARGUMENTS`.
CommandResult live_on(const std::string& session, const std::string& stream, const std::string& arguments) {
  return run_shell(drives(), "{ " + stream + "; } | '" + command_path() + "' live - --session " + session + " --method drive " + arguments);
}

const char* const limit = "--require 'gyro.matrix.zz <= 5000 ppm'";

// 1 % of the first turn's 360 deg are 3.6 deg, which velocities of 0.05 m/s at 8 m/s show to a tenth.
TEST(LiveDrive, EndsWhereTheRequirementIsMet) {
  const CommandResult r = live_on("drive", "cat drive/recording.csv", std::string(limit) + " -o done.json");
  EXPECT_EQ(r.exit_code, 0) << r.errors << r.output;
  EXPECT_THAT(r.output,
              ContainsRegex("reached: gyro.matrix.zz not determined\n.*missing: gyro.matrix.zz; shown by turns in both directions, of several full "
                            "circles\n"));
  EXPECT_THAT(r.output, ContainsRegex("done: gyro.matrix.zz .*\n[0-9]+ s: good; written: done.json\n$"));
  const Json c = Json::parse(read_text(drives() / "done.json"));
  EXPECT_EQ(c["method"], "drive");
  EXPECT_TRUE(c["quality"]["requirements"][0]["met"]);
}

// The pipe holds 64 kB: when the receiver's rows come, readings of more than that have been waited for, and with them the first estimate.
TEST(LiveDrive, WaitsForTheReceiver) {
  const CommandResult r = live_on(
      "drive", "rm drive/gnss_1.csv; head -n 2000 drive/recording.csv; cp drive/whole.csv drive/gnss_1.csv; tail -n +2001 drive/recording.csv",
      std::string(limit) + " --json --save drive/saved.csv");
  EXPECT_EQ(r.exit_code, 0) << r.errors << r.output;
  std::istringstream lines(r.output);
  std::string line, last;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_THAT(Json::parse(line)["problem"].get<std::string>(), HasSubstr("gnss_1.csv"));
  while (std::getline(lines, line)) last = line;
  EXPECT_TRUE(Json::parse(last)["done"]);
}

TEST(LiveDrive, AParkedCarShowsWhatIsMissing) {  // ctest: once
  const CommandResult r = live_on("parked", "cat parked/recording.csv", limit);
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.output, ContainsRegex("missing: gyro.matrix.zz; shown by turns in both directions"));
  EXPECT_THAT(r.errors, ContainsRegex("not reached: gyro.matrix.zz .*\n  what helps most: turns in both directions"));
  const CommandResult open = live_on("parked", "cat parked/recording.csv", "");
  EXPECT_THAT(open.output, ContainsRegex("missing: .*gyro.matrix.zz")) << "without requirements all that is not determined";
  EXPECT_THAT(open.output, Not(HasSubstr("done:")));
}

TEST(LiveDrive, WhatDoesNotGoIsSaid) {
  const CommandResult none = live_on("parked", "head -n 1 parked/recording.csv", limit);
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.errors, HasSubstr("standard input: has a header but no rows"));
  EXPECT_THAT(live_on("parked", "true", "--rest 3").errors, HasSubstr("--rest: belongs to a calibration by hand"));
  run_shell(drives(), "sed '/^\\[\\[aid\\]\\]/,$d' parked/session.toml > parked/alone.toml");
  EXPECT_THAT(live_on("parked/alone.toml", "cat parked/recording.csv", limit).errors, HasSubstr("alone.toml: has no aids; expected [[aid]]"));
}

}  // namespace
}  // namespace imulab
