// The command lines as a user types them.
#include "imulab/simulate.hpp"

#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <chrono>
#include <filesystem>
#include <string>

namespace imulab {
namespace {

namespace fs = std::filesystem;

class SimulateCommand : public testing::Test {
 protected:
  CommandResult imulab(const std::string& arguments) const { return run_imulab(folder, arguments); }
  TemporaryFolder folder;
};

TEST_F(SimulateCommand, AHandHeldProcedureBecomesASession) {
  const CommandResult procedure = imulab("procedure handheld --poses 5 --seed 3");
  ASSERT_EQ(procedure.exit_code, 0) << procedure.errors;
  folder.write("hand.toml", procedure.output);
  EXPECT_THAT(imulab("simulate hand.toml -o -").output, testing::HasSubstr("- (seed 1)\n")) << "a folder of this name: the answer is shown";
  const CommandResult run = imulab("simulate hand.toml -o out --seed 7");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, testing::HasSubstr("recording.csv  5400 samples, 54 s"));  // 30 s and four times 2 s + 4 s, at 100 Hz

  const Session asked = read_session(folder / "hand.toml"), given = read_session(folder / "out");
  EXPECT_EQ(asked.steps.size(), 5u);
  EXPECT_TRUE(given.steps.empty());  // nobody recorded what the hand did
  const Truth truth = draw_truth(asked, 7);
  const Recording expected = simulate_recording(asked, asked.recordings[0], truth, 7);
  const RecordingReading read = read_recording(given, given.recordings.at(0));
  EXPECT_THAT(read.warnings, testing::IsEmpty());
  EXPECT_EQ(read.recording.time_ns, expected.time_ns);
  EXPECT_EQ(read.recording.gyro, expected.gyro);
  EXPECT_EQ(read.recording.accel, expected.accel);
  const Calibration written = read_calibration(folder / "out/truth.json");
  EXPECT_EQ(written.method, "truth");
  EXPECT_EQ(written.model.gyro.matrix, truth.model.gyro.matrix);
  EXPECT_EQ(written.model.g_sensitivity, truth.model.g_sensitivity);
  EXPECT_EQ(written.covariance.size(), 0);
}

constexpr const char* table = R"(format = "imulab.session/1"
[imu]
name = "unit"
grade = "navigation"
[site]
latitude_deg = 40.0
[rig]
kind = "turntable"
angle_sigma_arcsec = 60
[[recording]]
file = "table.csv"
rate_hz = 50
time = { column = 1, unit = "ms" }
gyro = { columns = [2, 3, 4], output = "increment", unit = "deg" }
accel = { columns = [5, 6, 7], output = "rate", unit = "g" }
gyro_temperature = { columns = ["T"], unit = "degC" }
[[step]]
kind = "hold"
duration_s = 5
temperature_degC = 30
[[step]]
kind = "rotate"
axis = "middle"
angle_deg = 90
rate_dps = 10
)";

TEST_F(SimulateCommand, ATableKeepsItsStepsAndOutputsInSi) {
  folder.write("table.toml", table);
  const CommandResult run = imulab("simulate table.toml -o deep/er/");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(read_text(folder / "deep/er/truth.json"), testing::HasSubstr("\"angle.middle.2\": "));  // an arcminute, drawn
  const Session given = read_session(folder / "deep/er");
  ASSERT_EQ(given.steps.size(), 2u);
  EXPECT_EQ(given.steps[1].angle, 90 * unit::deg);
  const Recording r = read_recording(given, given.recordings.at(0)).recording;
  EXPECT_EQ(r.size(), 710u);  // 5 s, and 9 s + 0.2 s of ramp
  EXPECT_THAT(r.gyro_temperature[0], testing::Each(30.0));
  double turned = 0;
  for (const double w : r.gyro[1]) turned += w * r.interval_s;
  // Scale 20 ppm of 90 deg and an end less a start of one arcminute each, five sigma; Earth's rate for 14.2 s is at most 1e-3 rad;
  // misalignment of the cross axes is second order.
  EXPECT_NEAR(turned, 90 * unit::deg, 5 * (20e-6 * 90 * unit::deg + 1.5 * 60 * unit::arcsec) + 1.1e-3);
}

TEST_F(SimulateCommand, AGivenTruthIsSimulatedExactly) {
  folder.write("table.toml", table);
  ASSERT_EQ(imulab("simulate table.toml -o a --seed 5").exit_code, 0);
  std::string again = table;
  again.replace(again.find("grade"), 0, "truth = \"a/truth.json\"\n");
  folder.write("again.toml", again);
  ASSERT_EQ(imulab("simulate again.toml -o b --seed 5").exit_code, 0);
  EXPECT_EQ(read_text(folder / "a/table.csv"), read_text(folder / "b/table.csv"));
  EXPECT_FALSE(read_session(folder / "b").imu.truth);
}

TEST_F(SimulateCommand, WhatStandsIsNotOverwrittenAndNothingHalfDoneStays) {
  folder.write("table.toml", table);
  fs::create_directories(folder / "full");
  folder.write("full/mine.txt", "mine");
  const CommandResult run = imulab("simulate table.toml -o full");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, testing::HasSubstr("expected a new or an empty folder"));
  fs::create_directories(folder / "empty");
  EXPECT_EQ(imulab("simulate table.toml -o empty").exit_code, 0);

  std::string impossible = table;
  impossible +=
      "[[recording]]\nfile = \"b.csv\"\ntime = { column = 1, unit = \"s\" }\ngyro = { columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\n";
  impossible += "accel = { columns = [5, 6, 7], output = \"rate\", unit = \"count\" }\n";
  impossible.replace(impossible.find("duration_s = 5"), 0, "recording = \"table.csv\"\n");
  impossible.replace(impossible.find("axis ="), 0, "recording = \"table.csv\"\n");
  folder.write("impossible.toml", impossible);  // the second recording has no steps
  const CommandResult failed = imulab("simulate impossible.toml -o none");
  EXPECT_EQ(failed.exit_code, 2);
  EXPECT_THAT(failed.errors, testing::HasSubstr("the steps last less than one sample"));
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::StartsWith("none")));
}

TEST_F(SimulateCommand, WhatAMachineCannotDoIsRefused) {
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& message) {
    std::string text = imulab("procedure dai-unit --record 1").output;
    text.replace(text.find(from), from.size(), to);
    folder.write("dai.toml", text);
    const CommandResult run = imulab("simulate dai.toml -o dai");
    EXPECT_EQ(run.exit_code, 2) << to;
    EXPECT_THAT(run.errors, testing::HasSubstr(message));
    EXPECT_FALSE(fs::exists(folder / "dai")) << to;
  };
  refused("kind = \"hold\"\nrecording = \"chamber.csv\"\nduration_s = 1\nouter_deg = 0\nmiddle_deg = 0\ninner_deg = 0",
          "kind = \"spin\"\nrecording = \"chamber.csv\"\nduration_s = 1\nrate_dps = 5",
          "chamber.csv: step 1 (spin at 10 s): a chamber does not turn; expected hold");
  refused("radius_m = [6.104, 6.097, 6.101]\n", "", "centrifuge.csv: step 2 (spin at 61 s): no arm; expected a radius above 0");
  refused("up = \"+x\"\noutward = \"+y\"\n", "", "rate_table.csv: step 1 (spin at 60 s): no mount; expected the body axes");
  refused("duration_s = 1\nrate_dps = -380", "duration_s = 1\nmove_s = 0\nrate_dps = -380",
          "rate_table.csv: step 2 (spin at 61 s): its rate differs");
  refused("rate_dps = -380", "rate_dps = 0", "rate_table.csv: step 2 (spin at 71 s): the rate is 0; expected another rate, or hold");
}

TEST_F(SimulateCommand, AWholeUnitOnThreeMachines) {
  const CommandResult procedure = imulab("procedure dai-unit --record 2 --thermal resonance -o dai.toml");
  ASSERT_EQ(procedure.exit_code, 0) << procedure.errors;
  const auto begin = std::chrono::steady_clock::now();
  const CommandResult run = imulab("simulate dai.toml -o dai");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));  // 0.2 s; under sanitizers and load twenty times that
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, testing::HasSubstr("rate_table.csv 24600 samples"));
  const Session given = read_session(folder / "dai");
  EXPECT_EQ(given.steps.size(), 15u + 246 + 42);
  EXPECT_EQ(given.rigs, read_session(folder / "dai.toml").rigs);
  const Calibration truth = read_calibration(folder / "dai/truth.json");
  EXPECT_EQ(truth.frame, BodyFrame::rig);
  EXPECT_EQ(truth.model.gyro.temperature, (ThermalReading{"raw", 5000, {4993.25, 5003.75}}));
  EXPECT_EQ(truth.model.accel.temperature->range, (std::array{0.0, 70.0}));
  EXPECT_THAT(read_text(folder / "dai/truth.json"), testing::HasSubstr("\"radius.+y+x\": "));
  for (const RecordingSource& source : given.recordings) {
    const RecordingReading read = read_recording(given, source);
    EXPECT_THAT(read.warnings, testing::IsEmpty());  // no gap that the steps do not explain
    const Session asked = read_session(folder / "dai.toml");
    const Recording expected = simulate_recording(asked, source, draw_truth(asked, 1), 1, draw_rig_errors(asked, source, 1));
    EXPECT_EQ(read.recording.gaps, expected.gaps);
    EXPECT_EQ(read.recording.time_ns, expected.time_ns);
    EXPECT_EQ(read.recording.gyro, expected.gyro);
    EXPECT_EQ(read.recording.gyro_temperature, expected.gyro_temperature);
  }
  for (const char* method : {"static", "handheld", "turntable", "hybrid"})
    for (const char* recording : {"chamber.csv", "rate_table.csv", "centrifuge.csv"}) {
      const CommandResult refused = imulab(std::string("calibrate dai --method ") + method + " --recording " + recording);
      EXPECT_EQ(refused.exit_code, 2) << method << recording;
      EXPECT_THAT(refused.errors, testing::HasSubstr("\"turntable\""));
    }
}

}  // namespace
}  // namespace imulab
