// calibrate --method drive as people use it: simulated drives of drawn IMUs, and what is no drive.
#include "imulab/files.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/calibration_input.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Lt;
using ::testing::Not;
using Json = nlohmann::json;

// Poses of an ideal tracker in a tilted frame, by the simulator of procedures.
TEST(CalibrateByPoses, FindsTheUnit) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure handheld --grade mems --poses 20 -o p.toml").exit_code, 0);
  std::string procedure = read_text(folder / "p.toml");
  procedure.replace(procedure.find("[site]"), 6, "[site]\nlongitude_deg = 11");
  folder.write("p.toml", procedure +
                             "\n[[aid]]\nkind = \"pose\"\nposition_sigma_m = 0.001\nattitude_sigma_deg = 0.05\nrate_hz = 10\n"
                             "lever_arm_m = [0.1, 0.05, 0]\nlever_arm_sigma_m = 0.02\n");
  ASSERT_EQ(run_imulab(folder, "simulate p.toml -o s").exit_code, 0);
  const CommandResult made = run_imulab(folder, "calibrate s --method drive -o c.json");
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_THAT(made.output, HasSubstr("good: nothing contradicts"));
  const CommandResult compared = run_imulab(folder, "compare c.json s/truth.json");
  EXPECT_THAT(compared.output, HasSubstr("0 of 42 coefficients differ"));
  const Json found = Json::parse(read_text(folder / "c.json"));
  for (const Json& row : found["standard_uncertainty"]["gyro"]["matrix"])
    for (const Json& u : row) EXPECT_LT(u.get<double>(), 3e-4);
}

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

/// Session `name` with readings of the MEMS unit of unit/truth.json, without the state at its start, which no car knows, and without a site.
void write_drive(const TemporaryFolder& folder, const std::string& segments, const std::string& name = "drive", int seed = 5) {
  folder.write(name + ".toml", mission_head + segments);
  const CommandResult made = run_shell(folder, "I='" + command_path() + "' D=" + name + " S=" + std::to_string(seed) + R"(
[ -d unit ] || { $I procedure handheld --poses 9 --grade mems -o p.toml && $I simulate p.toml -o unit --seed 5; } &&
$I trajectory $D.toml --unit unit/truth.json --seed $S -o $D &&
sed -i -e '/^\[initial\]/,/^heading/d' -e '/^\[site\]/,/^height/d' $D/session.toml)");
  ASSERT_EQ(made.exit_code, 0) << made.errors;
}

TEST(CalibrateDriveCommand, StatesWhatADriveShowsAndNamesTheRest) {
  const TemporaryFolder folder;
  write_drive(folder, eight);
  const CommandResult result = run_imulab(folder, "calibrate drive --method drive -o c.json --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.errors), AllOf(HasSubstr("not determined"), HasSubstr("accel.matrix.zz; shown by rests upside down")));
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_EQ(c.quality.verdict, Verdict::good) << testing::PrintToString(c.quality.findings.reasons());
  EXPECT_EQ(c.frame, BodyFrame::accelerometers);
  // Of 33 coefficients and 12 of curvature the worst is beyond 4.2 sigma once in 1000.
  EXPECT_LT(largest_sigmas(c, read_calibration(folder / "unit/truth.json").model), 4.2);
  EXPECT_THAT(c.quality.considered, AllOf(Contains("accel.matrix.zz"), Contains("gyro.matrix.xx"), Not(Contains("gyro.matrix.zz"))));
  for (const char* shown : {"gyro.offset.x", "gyro.offset.z", "gyro.matrix.zz", "accel.offset.x", "accel.offset.y"})
    EXPECT_LT(*standard_uncertainty(c, coefficient_index(shown)), (std::string(shown).starts_with("accel.o") ? 0.1 : 2e-3)) << shown;
  bool arm = false;
  for (const RigErrorEstimate& e : c.quality.rig_errors) arm = arm || (e.name == "gnss.lever_arm.right" && e.uncertainty < 0.2);
  EXPECT_TRUE(arm);
  const std::string page = read_text(folder / "page.html");
  EXPECT_THAT(page, HasSubstr("gnss.lever_arm.right"));
  // What is as uncertain as before is no result: neither in the rows, nor on a card, nor for firmware.
  EXPECT_THAT(on_one_line(result.output), ContainsRegex("not determined, as uncertain as before the data: .*accel.matrix.zz.*gyro.matrix.xx"));
  EXPECT_THAT(page, AllOf(HasSubstr("Not determined, as uncertain as before the data: accel.matrix.z"), Not(HasSubstr("imulab export to firmware"))));
  EXPECT_THAT(
      on_one_line(result.output),
      ContainsRegex("good: nothing contradicts the stated uncertainties; not determined: [0-9]+ of 21 biases, scale factors and misalignments"));
  const CommandResult required = run_imulab(folder, "calibrate drive --method drive --require 'gyro.matrix.xx <= 50000 ppm' -o r.json");
  EXPECT_EQ(required.exit_code, 1);
  EXPECT_THAT(on_one_line(required.output), ContainsRegex("gyro.matrix.xx <= 50000 ppm: not met .*not determined"));
  const double gyro_scale = *standard_uncertainty(c, coefficient_index("gyro.matrix.zz")) / unit::ppm;
  EXPECT_THAT(on_one_line(result.output), HasSubstr(fmt::format("gyros scale {:.0f} ppm", 100 * std::round(gyro_scale / 100))));
  EXPECT_EQ(c.imu, "simulated IMU");
}

/// Predicted over stated sigma of what both have.
std::map<std::string, double> foreseen_over_stated(const Json& predicted, const Calibration& c) {
  std::map<std::string, double> out;
  for (const CoefficientIndex index : c.estimated)
    out[std::string(coefficient(index).name)] =
        predicted["coefficients"][std::string(coefficient(index).name)]["closed_form"].get<double>() / *standard_uncertainty(c, index);
  for (std::size_t k = 0; k < c.quality.rig_errors.size(); ++k) {
    EXPECT_EQ(predicted["rig_errors"][k]["name"], c.quality.rig_errors[k].name);
    out[c.quality.rig_errors[k].name] = predicted["rig_errors"][k]["standard_uncertainty"].get<double>() / c.quality.rig_errors[k].uncertainty;
  }
  return out;
}

// The estimator on simulated data against the covariance about the true motion, of other draws of the noise: the size that a drive shows of each
// noise, and what follows from it, scatters by a tenth.
TEST(PredictDriveCommand, ForeseesWhatCalibrateStates) {
  const TemporaryFolder folder;
  write_drive(folder, eight);
  ASSERT_EQ(run_imulab(folder, "calibrate drive --method drive -o c.json").exit_code, 0);
  const Calibration c = read_calibration(folder / "c.json");
  const CommandResult result = run_imulab(folder, "predict drive.toml --method drive --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const Json predicted = Json::parse(result.output);
  for (const auto& [name, ratio] : foreseen_over_stated(predicted, c)) EXPECT_THAT(ratio, AllOf(Gt(0.85), Lt(1.15))) << name;
}

TEST(PredictDriveCommand, ManoeuvresMatter) {
  const TemporaryFolder folder;
  const std::string straight = R"([[segment]]
kind = "accelerate"
to_mps = 8
duration_s = 5
[[segment]]
kind = "straight"
duration_s = 40
)";
  folder.write("straight.toml", std::string(mission_head) + straight);
  folder.write("eight.toml", std::string(mission_head) + eight);
  const CommandResult result = run_imulab(folder, "predict straight.toml --method drive --require 'gyro.matrix.zz <= 2000 ppm'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(on_one_line(result.output),
              AllOf(HasSubstr("not met: gyro.matrix.zz"), HasSubstr("gyro.matrix.zz; shown by turns in both directions")));
  EXPECT_EQ(run_imulab(folder, "predict eight.toml --method drive --require 'gyro.matrix.zz <= 2000 ppm'").exit_code, 0);
}

TEST(PlanDriveCommand, AddsManoeuvresUntilTheRequirementIsMet) {  // ctest: once
  const TemporaryFolder folder;
  folder.write("drive.toml", std::string(mission_head) + eight);
  const double without =
      Json::parse(run_imulab(folder, "predict drive.toml --method drive --json").output)["coefficients"]["gyro.matrix.zz"]["closed_form"];
  const std::string require = fmt::format(" --require 'gyro.matrix.zz <= {:.0f} ppm'", 0.97e6 * without);
  EXPECT_EQ(run_imulab(folder, "predict drive.toml --method drive" + require).exit_code, 1);
  const CommandResult planned = run_imulab(folder, "plan --mission drive.toml -o longer.toml --margin 1" + require);
  EXPECT_EQ(planned.exit_code, 0) << planned.errors;
  EXPECT_THAT(planned.output, AllOf(testing::StartsWith("met: added "), HasSubstr(" in all")));
  const std::string added = planned.output.substr(11, planned.output.find(':', 11) - 11);  // "slope"
  EXPECT_EQ(run_imulab(folder, "predict longer.toml --method drive" + require).exit_code, 0);
  folder.write("plan.json", run_imulab(folder, "plan --mission drive.toml --margin 1 --json" + require).output);
  EXPECT_EQ(run_imulab(folder, "report plan.json -o plan.html").exit_code, 0);
  EXPECT_THAT(read_text(folder / "plan.html"), HasSubstr(added));
  const CommandResult never = run_imulab(folder, "plan --mission drive.toml --require 'gyro.matrix.yy <= 10 ppm'");
  EXPECT_EQ(never.exit_code, 1);
  EXPECT_THAT(on_one_line(never.errors), HasSubstr("no maneuver of the table brings the drive to the requirements: gyro.matrix.yy"));
  folder.write("flight.toml", std::regex_replace(mission_head + std::string(eight), std::regex("vehicle"), "aircraft"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "plan --mission flight.toml" + require).errors), HasSubstr("imulab predict --method drive judges"));
}

// Each drive adds its information on the scales, but for what coefficients that neither shows do to both alike: a tenth. Effects are those of the
// unit, alike in all of its drives.
TEST(CalibrateDriveCommand, SeveralDrivesAreOneCalibration) {
  const TemporaryFolder folder;
  write_drive(folder, eight);
  write_drive(folder, eight, "again", 6);
  const auto calibrated = [&](const std::string& sessions) {
    const CommandResult result = run_imulab(folder, "calibrate " + sessions + " --method drive --effects none -o c.json --force");
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return read_calibration(folder / "c.json");
  };
  const Calibration one = calibrated("drive"), other = calibrated("again"), both = calibrated("drive again");
  EXPECT_EQ(both.quality.verdict, Verdict::good) << testing::PrintToString(both.quality.findings.reasons());
  EXPECT_LT(largest_sigmas(both, read_calibration(folder / "unit/truth.json").model), 4.2);
  const auto sigma = [](const Calibration& c, const char* name) { return *standard_uncertainty(c, coefficient_index(name)); };
  for (const char* shown : {"accel.matrix.xx", "accel.matrix.yy"})
    EXPECT_NEAR(std::hypot(sigma(both, shown) / sigma(one, shown), sigma(both, shown) / sigma(other, shown)), 1, 0.1) << shown;
  for (const CoefficientIndex index : both.estimated)
    if (coefficient(index).term == Term::matrix)
      EXPECT_LT(*standard_uncertainty(both, index), 1.001 * std::min(*standard_uncertainty(one, index), *standard_uncertainty(other, index)));
  const Calibration with_effects = [&] {
    run_imulab(folder, "calibrate drive again --method drive -o c.json --force");
    return read_calibration(folder / "c.json");
  }();
  EXPECT_EQ(with_effects.quality.verdict, Verdict::good);
  EXPECT_LT(largest_sigmas(with_effects, read_calibration(folder / "unit/truth.json").model), 4.2);
  EXPECT_GT(sigma(with_effects, "accel.matrix.xx"), 1.1 * sigma(both, "accel.matrix.xx"));
  EXPECT_THAT(testing::PrintToString(with_effects.quality.considered), HasSubstr("accel.cross_terms"));
  EXPECT_THAT(testing::PrintToString(both.quality.findings.notes()),
              AllOf(HasSubstr("recording.csv: gnss.delay"), HasSubstr("again/recording.csv: gnss.delay")));
  // Readings of gyros about z that are 3 % off are another unit's.
  run_shell(folder, "awk -F, -v OFS=, 'NR > 1 {$4 *= 1.03} 1' again/recording.csv > x && mv x again/recording.csv");
  const CommandResult mixed = run_imulab(folder, "calibrate drive again --method drive");
  EXPECT_THAT(on_one_line(mixed.output), AllOf(HasSubstr("doubtful"), HasSubstr("contradicts the other drive"), HasSubstr("most in gyro.matrix.zz")));
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

/// After the receiver's last word an accelerometer changes, which the navigation cannot see, but gravity at the last rest can.
TEST(CalibrateDriveCommand, RestsThatContradictAreADoubt) {
  const TemporaryFolder folder;
  write_drive(folder, std::string(eight) + "[[segment]]\nkind = \"rest\"\nduration_s = 20\n");
  EXPECT_THAT(run_imulab(folder, "calibrate drive --method drive").output, Not(HasSubstr("from gravity")));
  run_shell(folder, R"(cd drive
awk -F, 'NR < 3 || $1 < 68' gnss_1.csv > g && mv g gnss_1.csv
awk -F, -v OFS=, 'NR > 1 && $1 > 69.6 { $7 += 0.3 } 1' recording.csv > r && mv r recording.csv)");
  const CommandResult changed = run_imulab(folder, "calibrate drive --method drive");
  EXPECT_THAT(on_one_line(changed.output), ContainsRegex("doubtful: .*the calibrated force is .* mg from gravity, where .* mg is its uncertainty"));
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
  refused("true", "other: recording.csv was given before", "other");
  refused(
      "sed -n '/^\\[\\[rec/,/^accel/p' other/session.toml | sed s/recording.csv/other.csv/ >> other/session.toml; cp other/recording.csv "
      "other/other.csv",
      "gnss_1.csv: goes with which of the 2 recordings? expected recording = \"recording.csv\"");
  refused("true", "gyro.cubic.x is not a coefficient that the method drive estimates", "--terms gyro.cubic.x");
}

}  // namespace
}  // namespace imulab
