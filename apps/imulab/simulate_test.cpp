// The command lines as a user types them.
#include "imulab/simulate/simulate.hpp"

#include "imulab/core/units.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/recording_file.hpp"
#include "imulab/io/session_file.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <sys/wait.h>

namespace imulab {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int code;
  std::string output;  // standard output and standard error
};

Outcome imulab(const std::string& arguments) {
  FILE* const pipe = popen(fmt::format("{} {} 2>&1", IMULAB_COMMAND, arguments).c_str(), "r");
  Outcome run{-1, ""};
  std::array<char, 4096> buffer;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) run.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  run.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

class SimulateCommand : public testing::Test {
 protected:
  SimulateCommand() : folder(fs::temp_directory_path() / fmt::format("imulab-simulate-{}", std::random_device{}())) {
    fs::create_directories(folder);
  }
  ~SimulateCommand() override { fs::remove_all(folder); }
  std::string in(const char* name) const { return (folder / name).string(); }
  fs::path folder;
};

TEST_F(SimulateCommand, AHandHeldProcedureBecomesASession) {
  const Outcome procedure = imulab("procedure hand-held --poses 5 --seed 3");
  ASSERT_EQ(procedure.code, 0) << procedure.output;
  write(in("hand.toml"), procedure.output);
  const Outcome run = imulab(fmt::format("simulate {} -o {} --seed 7", in("hand.toml"), in("out")));
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_THAT(run.output, testing::HasSubstr("recording.csv  5400 samples, 54 s"));  // 30 s and four times 2 s + 4 s, at 100 Hz

  const Session asked = read_session(in("hand.toml")), given = read_session(in("out"));
  EXPECT_EQ(asked.steps.size(), 5u);
  EXPECT_TRUE(given.steps.empty());  // nobody recorded what the hand did
  const Truth truth = draw_truth(asked, 7);
  const Recording expected = simulate_recording(asked, asked.recordings[0], truth, 7);
  const RecordingReading read = read_recording(given, given.recordings.at(0));
  EXPECT_THAT(read.warnings, testing::IsEmpty());
  EXPECT_EQ(read.recording.time_ns, expected.time_ns);
  EXPECT_EQ(read.recording.gyro, expected.gyro);
  EXPECT_EQ(read.recording.accel, expected.accel);
  const Calibration written = read_calibration(fs::path(in("out")) / "truth.json");
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
  write(in("table.toml"), table);
  const Outcome run = imulab(fmt::format("simulate {} -o {}/", in("table.toml"), in("deep/er")));
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_THAT(text_of(fs::path(in("deep/er")) / "truth.json"), testing::HasSubstr("\"angle.middle.2\": "));  // an arcminute, drawn
  const Session given = read_session(in("deep/er"));
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
  write(in("table.toml"), table);
  ASSERT_EQ(imulab(fmt::format("simulate {} -o {} --seed 5", in("table.toml"), in("a"))).code, 0);
  std::string again = table;
  again.replace(again.find("grade"), 0, "truth = \"a/truth.json\"\n");
  write(in("again.toml"), again);
  ASSERT_EQ(imulab(fmt::format("simulate {} -o {} --seed 5", in("again.toml"), in("b"))).code, 0);
  EXPECT_EQ(text_of(fs::path(in("a")) / "table.csv"), text_of(fs::path(in("b")) / "table.csv"));
  EXPECT_FALSE(read_session(in("b")).imu.truth);
}

TEST_F(SimulateCommand, WhatStandsIsNotOverwrittenAndNothingHalfDoneStays) {
  write(in("table.toml"), table);
  fs::create_directories(in("full"));
  write(in("full/mine.txt"), "mine");
  const Outcome run = imulab(fmt::format("simulate {} -o {}", in("table.toml"), in("full")));
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.output, testing::HasSubstr("a new or an empty folder was expected"));
  fs::create_directories(in("empty"));
  EXPECT_EQ(imulab(fmt::format("simulate {} -o {}", in("table.toml"), in("empty"))).code, 0);

  std::string impossible = table;
  impossible +=
      "[[recording]]\nfile = \"b.csv\"\ntime = { column = 1, unit = \"s\" }\ngyro = { columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\n";
  impossible += "accel = { columns = [5, 6, 7], output = \"rate\", unit = \"count\" }\n";
  impossible.replace(impossible.find("duration_s = 5"), 0, "recording = \"table.csv\"\n");
  impossible.replace(impossible.find("axis ="), 0, "recording = \"table.csv\"\n");
  write(in("impossible.toml"), impossible);  // the second recording has no steps
  const Outcome failed = imulab(fmt::format("simulate {} -o {}", in("impossible.toml"), in("none")));
  EXPECT_EQ(failed.code, 2);
  EXPECT_THAT(failed.output, testing::HasSubstr("no steps"));
  for (const auto& entry : fs::directory_iterator(folder)) EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::StartsWith("none")));
}

}  // namespace
}  // namespace imulab
