#include "imulab/files.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const char* const session_head = R"(format = "imulab.session/1"
[imu]
name = "unit"
[site]
latitude_deg = 40.0
[rig]
kind = "none"
)";

std::string recording_entry(const std::string& file, const std::string& more = "") {
  return "[[recording]]\nfile = \"" + file + R"("
rate_hz = 100.0
time = { column = "t", unit = "s" }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "count" }
accel = { columns = ["ax", "ay", "az"], output = "rate", unit = "count", limits = [-100, 100] }
)" + more +
         "\n";
}

/// A session of the named recordings, three samples each, the temperature running 20, 30, 80 degC.
void write_session(const TemporaryFolder& folder, const std::vector<std::string>& files, const std::string& more = "") {
  std::filesystem::create_directories(folder / "session");
  std::string session = session_head;
  for (const auto& file : files) {
    session += recording_entry(file, more);
    folder.write("session/" + file, "t,gx,gy,gz,ax,ay,az,T\n0.01,1,2,3,4,5,6,20\n0.02,2,4,6,8,10,100,30\n0.03,3,6,9,12,15,18,80\n");
  }
  folder.write("session/session.toml", session);
}

Calibration scaled_calibration() {
  Calibration c;
  c.model.gyro.matrix.diagonal() << 2, 3, 4;
  c.model.accel.offset << 0.5, 0, 0;
  return c;
}

Calibration thermal_calibration() {
  Calibration c = scaled_calibration();
  c.model.gyro.temperature = ThermalReading{"degC", 20, {0, 70}};
  c.model.gyro.thermal(0, 1) = 0.1;
  return c;
}

const std::string expected_samples = "t,gx,gy,gz,ax,ay,az,flags\n0.01,2,6,12,4.5,5,6,\n0.02,4,12,24,8.5,10,100,saturated\n0.03,6,18,36,12.5,15,18,\n";

TEST(CompensateCommand, WritesOneRecordingToAFileAFolderOrStandardOutput) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"});
  folder.write("calibration.json", calibration_text(scaled_calibration()));
  const CommandResult stream = run_imulab(folder, "compensate calibration.json session -o -");
  EXPECT_EQ(stream.exit_code, 0) << stream.errors;
  EXPECT_EQ(stream.output, expected_samples);
  EXPECT_THAT(stream.errors, HasSubstr("imulab: warning: "));  // a saturated sample
  EXPECT_EQ(run_imulab(folder, "compensate calibration.json session/session.toml -o one.csv").exit_code, 0);
  EXPECT_EQ(read_text(folder / "one.csv"), expected_samples);
  EXPECT_EQ(run_imulab(folder, "compensate calibration.json session --output out/of/folder").exit_code, 0);
  EXPECT_EQ(read_text(folder / "out/of/folder/recording.csv"), expected_samples);
}

TEST(CompensateCommand, WritesSeveralRecordingsToAFolder) {
  const TemporaryFolder folder;
  write_session(folder, {"a.csv", "b.txt"});
  folder.write("calibration.json", calibration_text(scaled_calibration()));
  EXPECT_EQ(run_imulab(folder, "compensate calibration.json session -o out").exit_code, 0);
  EXPECT_EQ(read_text(folder / "out/a.csv"), expected_samples);
  EXPECT_EQ(read_text(folder / "out/b.csv"), expected_samples);
  for (const char* single : {"out.csv", "-"}) {
    const CommandResult refused = run_imulab(folder, std::string("compensate calibration.json session -o ") + single);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.errors, HasSubstr("the session has 2 recordings; expected a folder"));
    EXPECT_EQ(refused.output, "");
  }
}

TEST(CompensateCommand, UsesTheTemperatureAndFlagsWhatTheCalibrationNeverSaw) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"}, "gyro_temperature = { columns = [\"T\"], unit = \"degC\" }");
  folder.write("calibration.json", calibration_text(thermal_calibration()));
  const CommandResult result = run_imulab(folder, "compensate calibration.json session -o -");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  // gx = 2 (U - 0.1 (T - 20)), T at most 70: 2 (1, 2 - 1, 3 - 5)
  EXPECT_EQ(result.output,
            "t,gx,gy,gz,ax,ay,az,flags\n0.01,2,6,12,4.5,5,6,\n0.02,2,12,24,8.5,10,100,saturated\n0.03,-4,18,36,12.5,15,18,out_of_range\n");
  EXPECT_THAT(result.errors, HasSubstr("1 of 3 samples are outside the calibrated temperatures"));
}

TEST(CompensateCommand, WhatCannotBeDoneLeavesNothingBehind) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"});
  folder.write("calibration.json", calibration_text(scaled_calibration()));
  folder.write("thermal.json", calibration_text(thermal_calibration()));
  folder.write("broken.json", "{");
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c : {Case{"thermal.json session -o out.csv",
                             "imulab: recording.csv: the calibration has thermal terms, but the recording has no gyro temperature"},
                        Case{"broken.json session -o out.csv", "imulab: broken.json:1: not JSON"},
                        Case{"absent.json session -o out.csv", "imulab: absent.json: "}, Case{"calibration.json absent -o out.csv", "imulab: absent"},
                        Case{"calibration.json session -o session/recording.csv", "imulab: -o session/recording.csv: would overwrite"},
                        Case{"calibration.json session -o session", "imulab: -o session/recording.csv: would overwrite session/recording.csv"},
                        Case{"calibration.json session -o calibration.json", "imulab: -o calibration.json: exists and is not a folder"},
                        Case{"calibration.json session", "--output is required"}}) {
    const std::string before = read_text(folder / "session/recording.csv");
    const CommandResult result = run_imulab(folder, std::string("compensate ") + c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments;
    EXPECT_THAT(result.errors, HasSubstr(c.message)) << c.arguments;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv")) << c.arguments;
    EXPECT_EQ(read_text(folder / "session/recording.csv"), before);
  }
}

TEST(CompensateCommand, WithoutARangeNoTemperatureIsOutside) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"}, "gyro_temperature = { columns = [\"T\"], unit = \"degC\" }");
  Calibration c = thermal_calibration();
  c.model.gyro.temperature->range = {0, 0};
  folder.write("calibration.json", calibration_text(c));
  const CommandResult result = run_imulab(folder, "compensate calibration.json session -o -");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, Not(HasSubstr("out_of_range")));
}

TEST(CompensateCommand, RejectsOutliersOnRequest) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"});
  std::string text = "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < 200; ++i) {  // steady but for a flicker of one count, and a spike once that is known
    const int x = i % 7 == 0 ? 1 : 0, spike = i == 150 ? 90 : 0;
    text += fmt::format("{:.2f},{},2,3,4,5,{}\n", 0.01 * i, x, 6 + spike);
  }
  folder.write("session/recording.csv", text);
  folder.write("calibration.json", calibration_text(scaled_calibration()));
  const CommandResult kept = run_imulab(folder, "compensate calibration.json session -o -");
  EXPECT_THAT(kept.output, HasSubstr("\n1.5,0,6,12,4.5,5,96\n"));
  // az has shown no resolution but the spike's own: a limit of the filter that its page names.
  const CommandResult rejected = run_imulab(folder, "compensate calibration.json session -o - --reject-outliers");
  EXPECT_EQ(rejected.output, kept.output);
  text.replace(text.find("0.20,0,2,3,4,5,6\n"), 17, "0.20,0,2,3,4,5,7\n");
  folder.write("session/recording.csv", text);
  const CommandResult shown = run_imulab(folder, "compensate calibration.json session -o out.csv --reject-outliers");
  EXPECT_EQ(on_one_line(shown.output), "out.csv: 200 samples, 0 saturated, 0 outside the calibrated temperatures, 1 with an outlier replaced");
  EXPECT_THAT(read_text(folder / "out.csv"), HasSubstr("\n1.5,0,6,12,4.5,5,6,replaced\n"));
}

TEST(CompensateCommand, TemperaturesInAnotherUnitAreRefused) {
  const TemporaryFolder folder;
  write_session(folder, {"recording.csv"}, "gyro_temperature = { columns = [\"T\"], unit = \"K\" }");
  folder.write("calibration.json", calibration_text(thermal_calibration()));
  const CommandResult result = run_imulab(folder, "compensate calibration.json session -o -");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("recording.csv: the gyro temperature is in K; expected degC as in the calibration"));
}

}  // namespace
}  // namespace imulab
