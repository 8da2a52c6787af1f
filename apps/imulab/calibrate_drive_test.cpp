// calibrate --method drive as people use it: simulated drives of drawn IMUs, and what is no drive.
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/calibration_input.hpp"
#include "tests/run_command.hpp"

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

const char* const mission_head = R"(format = "imulab.mission/1"
rate_hz = 25
truth_rate_hz = 1
carrier = "vehicle"
[start]
latitude_deg = 48.1
longitude_deg = 11.6
height_m = 520
heading_deg = 40
[errors]
gyro = { angle_random_walk_deg_per_sqrt_h = 0.3 }
accel = { velocity_random_walk_ug_per_sqrt_hz = 150 }
[[aid]]
kind = "gnss"
lever_arm_m = [0.1, 0.5, 1.0]
lever_arm_sigma_m = 0.2
delay_sigma_s = 0.05
position_sigma_m = 1
velocity_sigma_mps = 0.05
correlation_s = 60
[[segment]]
kind = "rest"
duration_s = 10
)";
/// A slope, and circles in both directions.
const char* const eight = R"([[segment]]
kind = "accelerate"
to_mps = 8
duration_s = 5
[[segment]]
kind = "climb"
angle_deg = 5
duration_s = 6
pitch_s = 3
[[segment]]
kind = "turn"
angle_deg = 360
rate_dps = 22
[[segment]]
kind = "turn"
angle_deg = -360
rate_dps = 22
[[segment]]
kind = "brake"
duration_s = 4
)";

/// Session `drive` with readings of the MEMS unit of unit/truth.json, without the state at its start, which no car knows.
void write_drive(const TemporaryFolder& folder, const std::string& segments) {
  folder.write("drive.toml", mission_head + segments);
  const CommandResult made = run_shell(folder, "I='" + command_path() + R"('
$I procedure handheld --poses 9 --grade mems -o p.toml && $I simulate p.toml -o unit --seed 5 &&
$I trajectory drive.toml --unit unit/truth.json --seed 5 -o drive &&
sed -i -e '/^\[initial\]/,/^heading/d' -e 's/^\[imu\]/&\ngrade = "mems"/' drive/session.toml)");
  ASSERT_EQ(made.exit_code, 0) << made.errors;
}

TEST(CalibrateDriveCommand, StatesWhatADriveShowsAndNamesTheRest) {
  const TemporaryFolder folder;
  write_drive(folder, eight);
  const CommandResult result = run_imulab(folder, "calibrate drive --method drive -o c.json --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.errors), AllOf(HasSubstr("not determined"), HasSubstr("accel.matrix.zz; shown by rests upside down")));
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_EQ(c.quality.verdict, "good") << testing::PrintToString(c.quality.because);
  EXPECT_EQ(c.frame, "accelerometers");
  // Of 33 coefficients and 12 of curvature the worst is beyond 4.2 sigma once in 1000.
  EXPECT_LT(largest_sigmas(c, read_calibration(folder / "unit/truth.json").model), 4.2);
  EXPECT_THAT(c.quality.considered, AllOf(Contains("accel.matrix.zz"), Contains("gyro.matrix.xx"), Not(Contains("gyro.matrix.zz"))));
  for (const char* shown : {"gyro.offset.x", "gyro.offset.z", "gyro.matrix.zz", "accel.offset.x", "accel.offset.y"})
    EXPECT_LT(*standard_uncertainty(c, coefficient_index(shown)), (std::string(shown).starts_with("accel.o") ? 0.1 : 2e-3)) << shown;
  bool arm = false;
  for (const RigErrorEstimate& e : c.quality.rig_errors) arm = arm || (e.name == "gnss.lever_arm.right" && e.uncertainty < 0.2);
  EXPECT_TRUE(arm);
  EXPECT_THAT(read_text(folder / "page.html"), HasSubstr("gnss.lever_arm.right"));
}

TEST(CalibrateDriveCommand, AParkedCarIsDoubtful) {
  const TemporaryFolder folder;
  write_drive(folder, "[[segment]]\nkind = \"rest\"\nduration_s = 40\n");
  const CommandResult result = run_imulab(folder, "calibrate drive --method drive --json");
  ASSERT_NE(result.output.find('{'), std::string::npos) << result.errors;
  const Json json = Json::parse(result.output);
  EXPECT_EQ(json["quality"]["verdict"], "doubtful");
  EXPECT_THAT(json["quality"]["because"].dump(), HasSubstr("the motion does not show the heading"));
  EXPECT_THAT(json["quality"]["considered"].dump(), AllOf(HasSubstr("gyro.matrix.zz"), HasSubstr("accel.offset.x")));
}

TEST(CalibrateDriveCommand, SaysWhatADriveLacks) {
  const TemporaryFolder folder;
  write_drive(folder, "");
  const auto refused = [&](const std::string& change, const std::string& why, const std::string& options = "") {
    run_shell(folder, "rm -rf other; cp -r drive other; " + change);
    const CommandResult result = run_imulab(folder, "calibrate other --method drive " + options);
    EXPECT_EQ(result.exit_code, 2) << change;
    EXPECT_THAT(on_one_line(result.errors), HasSubstr(why)) << change;
  };
  refused("sed -i '/^\\[\\[aid/,$d' other/session.toml", "has no aids, which the method drive needs; expected [[aid]]");
  refused("sed -i 's/^\\([0-9]\\)/9\\1/' other/gnss_1.csv", "overlap");
  refused("sed -i 's,unit = \"rad/s\",unit = \"count\",' other/session.toml", "gyro in counts, whose size a drive does not tell");
  refused("true", "the method drive takes one recording; got 2", "drive");
  refused("true", "gyro.cubic.x is not a coefficient that the method drive estimates", "--terms gyro.cubic.x");
}

}  // namespace
}  // namespace imulab
