// A recording without a session: what the command makes of it.
#include "imulab/compare.hpp"
#include "imulab/files.hpp"
#include "imulab/inspection/inspection.hpp"

#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <chrono>
#include <cmath>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path data = std::filesystem::path(IMULAB_SOURCE) / ".." / "shared" / "data";

/// The handheld session, its recording alone as log.csv.
void write_log(const TemporaryFolder& folder) {
  hand_held_session().write(folder);
  ASSERT_EQ(run_shell(folder, "cp session/recording.csv log.csv").exit_code, 0);
}

/// The largest difference of two calibrations' offsets and matrices, relative to each value's size or 1e-3.
double difference(const Calibration& a, const Calibration& b) {
  const auto values = [](const Calibration& c) {
    std::vector<double> v;
    for (const TriadModel* triad : {&c.model.accel, &c.model.gyro})
      for (Eigen::Index i = 0; i < 3; ++i) {
        v.push_back(triad->offset[i]);
        for (Eigen::Index j = 0; j < 3; ++j) v.push_back(triad->matrix(i, j));
      }
    return v;
  };
  const std::vector<double> x = values(a), y = values(b);
  double largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, std::abs(x[i] - y[i]) / std::max(1e-3, std::abs(x[i])));
  return largest;
}

TEST(InspectCommand, WritesASessionThatCalibratesAsTheOneWrittenByHand) {
  const TemporaryFolder folder;
  write_log(folder);
  const Session by_hand = read_session(folder / "session");
  const std::string place = " --set latitude_deg=" + std::to_string(*by_hand.site.latitude * 180 / 3.14159265358979) +
                            " --set height_m=" + std::to_string(by_hand.site.height.value_or(0));
  const CommandResult result = run_imulab(folder, "inspect log.csv" + place + " -o found.toml --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors << result.output;
  EXPECT_THAT(result.output, testing::StartsWith("understood: "));
  EXPECT_THAT(result.output, HasSubstr("written: found.toml"));
  EXPECT_THAT(read_text(folder / "page.html"), HasSubstr("understood"));
  ASSERT_EQ(run_imulab(folder, "calibrate found.toml --method handheld -o found.json").exit_code, 0);
  ASSERT_EQ(run_shell(folder, "sed '/^\\[\\[step/,$d; /^grade/d' session/session.toml > session/without.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "calibrate session/without.toml --method handheld -o by_hand.json").exit_code, 0);
  EXPECT_LT(difference(read_calibration(folder / "found.json"), read_calibration(folder / "by_hand.json")), 1e-6) << "latitude in six decimals";
}

TEST(InspectCommand, CalibratesARecordingAndSaysWhatItAssumed) {
  const TemporaryFolder folder;
  write_log(folder);
  const CommandResult result = run_imulab(folder, "calibrate log.csv --method handheld -o c.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors,
              testing::StartsWith("imulab: assumed: 100 Hz; gyro gx, gy, gz in rad/s; accel ax, ay, az in m/s^2; gravity 9.806 m/s^2 (u = 0.015"));
  EXPECT_THAT(run_imulab(folder, "calibrate log.csv --method handheld -o why.json --verbose").errors,
              HasSubstr("imulab: assumed: accelerometers: ax, ay, az: |a| at rest"));
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_NEAR(*standard_uncertainty(c, coefficient_index("accel.matrix.xx")) / c.model.accel.matrix(0, 0), 0.015 / 9.806, 2e-4)
      << "what is not known of gravity is in the scale";
  EXPECT_EQ(run_imulab(folder, "verify c.json").exit_code, 0) << "the recording is its own session";
}

TEST(InspectCommand, CalibratesSeveralRecordingsOfOneUnitAsOne) {
  const TemporaryFolder folder;
  write_log(folder);
  ASSERT_EQ(run_shell(folder,
                      "n=$(($(wc -l < log.csv) / 2)); head -$n log.csv > a.csv; mkdir second; "
                      "(head -1 log.csv; tail -n +$(($n + 1)) log.csv) > second/b.csv")
                .exit_code,
            0);
  ASSERT_EQ(run_imulab(folder, "calibrate log.csv --method static -o one.json").exit_code, 0);
  const CommandResult both = run_imulab(folder, "calibrate a.csv second/b.csv --method static -o both.json --verbose");
  EXPECT_EQ(both.exit_code, 0) << both.errors;
  EXPECT_THAT(both.output, HasSubstr("2 recordings of one IMU were calibrated together"));
  const Calibration c = read_calibration(folder / "both.json");
  for (const CoefficientIndex index : select_coefficients("accel.offset"))
    EXPECT_NEAR(coefficient_value(c.model, index), coefficient_value(read_calibration(folder / "one.json").model, index),
                3 * *standard_uncertainty(c, index));
  const CommandResult twice = run_imulab(folder, "calibrate a.csv ./a.csv --method static");
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_THAT(twice.errors, HasSubstr("./a.csv: a.csv was given before"));
  const CommandResult elsewhere = run_imulab(folder, "calibrate session a.csv --method static");
  EXPECT_EQ(elsewhere.exit_code, 2);
  EXPECT_THAT(elsewhere.errors, HasSubstr("a.csv: its ["));
}

TEST(InspectCommand, AsksForWhatTheDataLeaveOpen) {
  const TemporaryFolder folder;
  write_log(folder);
  ASSERT_EQ(run_shell(folder, "cut -d, -f2- log.csv | sed 1d > bare.csv").exit_code, 0);
  const CommandResult asked = run_imulab(folder, "inspect bare.csv -o bare.toml");
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.output, HasSubstr("? rate_hz: the rows have no stamps"));
  EXPECT_FALSE(std::filesystem::exists(folder / "bare.toml"));
  EXPECT_THAT(run_imulab(folder, "inspect bare.csv -o -").errors, HasSubstr("no session; declare with --set KEY=VALUE:\n  rate_hz: the rows have"));
  const CommandResult refused = run_imulab(folder, "calibrate bare.csv --method handheld");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("rate_hz: the rows have no stamps"));
  EXPECT_EQ(run_imulab(folder, "inspect bare.csv --set rate_hz=100 -o bare.toml").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "calibrate bare.toml --method handheld").exit_code, 0);
  const CommandResult json = run_imulab(folder, "inspect bare.csv --json");
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_THAT(json.output, HasSubstr("\"rate_hz\": null"));
  EXPECT_THAT(json.output, HasSubstr("\"role\": \"accel.x\""));
}

TEST(InspectCommand, RefusesWhatIsNoRecording) {
  const TemporaryFolder folder;
  write_log(folder);
  folder.write("empty.csv", "");
  folder.write("short.csv", "t,ax\n1,2\n2,3\n");
  folder.write("prose.txt", "It was a dark and stormy night.\nThe rain fell in torrents.\n");
  for (const std::string file : {"empty.csv", "short.csv", "prose.txt", "absent.csv"}) {
    const CommandResult result = run_imulab(folder, "inspect " + file);
    EXPECT_EQ(result.exit_code, 2) << file << result.output;
    EXPECT_THAT(result.errors, HasSubstr(file)) << file;
  }
  folder.write("other.toml", "a = 1\n");
  EXPECT_THAT(run_imulab(folder, "inspect other.toml").errors, HasSubstr("other.toml: is no session, and no recording: settings"));
  EXPECT_THAT(run_imulab(folder, "inspect log.csv --set gyro.unit").errors, HasSubstr("--set gyro.unit: has no value; expected KEY=VALUE"));
  EXPECT_THAT(run_imulab(folder, "inspect log.csv -o log.csv --force").errors, HasSubstr("would overwrite log.csv"));
  EXPECT_THAT(run_imulab(folder, "calibrate session --method handheld --set rate_hz=100").errors, HasSubstr("--set: declares a recording"));
  EXPECT_EQ(run_shell(folder, std::string("cat log.csv | '") + command_path() + "' inspect -").exit_code, 0) << "a pipe";
}

TEST(InspectCommand, UnderstandsRealRecords) {
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "the recorded data are not here";
  const TemporaryFolder folder;
  const std::string d = data.string();
  const struct {
    std::string files, set, gyro, accel, time;
  } records[] = {
      {d + "/imu_tk_xsens/xsens_acc.mat " + d + "/imu_tk_xsens/xsens_gyro.mat", "", "count", "count", "s"},
      {d + "/mpu9150_by_hand/imu3.log", " --set rate_hz=100", "rad/s", "m/s^2", "sample"},
      {d + "/imucal_ferraris/example_ferraris_session.csv", " --set rate_hz=102.4", "deg/s", "m/s^2", "sample"},
  };
  for (const auto& r : records) {
    std::filesystem::remove(folder / "s.toml");
    const CommandResult result = run_imulab(folder, "inspect " + r.files + r.set + " -o s.toml");
    ASSERT_EQ(result.exit_code, 0) << r.files << result.errors << result.output;
    const RecordingSource source = read_session(folder / "s.toml").recordings.at(0);
    EXPECT_EQ(source.gyro.unit, r.gyro) << r.files;
    EXPECT_EQ(source.accel.unit, r.accel) << r.files;
    EXPECT_EQ(source.time.unit, r.time) << r.files;
  }
  // As the sessions written by hand: the Xsens in counts, gravity as its authors computed.
  const std::string acc = d + "/imu_tk_xsens/xsens_acc.mat", gyr = d + "/imu_tk_xsens/xsens_gyro.mat";
  folder.write(
      "hand.toml",
      "format = \"imulab.session/1\"\n[site]\ngravity_mps2 = 9.81744\n[[recording]]\nfile = \"" + gyr +
          "\"\ntime = { column = 1, unit = \"s\" }\ngyro = { columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\naccel = { file = \"" + acc +
          "\", columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\n");
  ASSERT_EQ(run_imulab(folder, "inspect " + acc + " " + gyr + " --set gravity_mps2=9.81744 -o found.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "calibrate hand.toml --method handheld -o hand.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "calibrate found.toml --method handheld -o found.json").exit_code, 0);
  EXPECT_LT(difference(read_calibration(folder / "found.json"), read_calibration(folder / "hand.json")), 1e-9) << "the same numbers go in";
}

/// A serial port has no end; its last row may be cut.
TEST(InspectCommand, AStreamWithoutAnEndIsLeft) {
  const TemporaryFolder folder;
  write_log(folder);
  const std::string endless = "mkfifo port; (cat log.csv; printf '9999,1'; exec sleep 100) > port 2>&1 & writer=$!; ";
  const auto run = [&](const std::string& arguments) {
    return run_shell(folder, endless + "'" + command_path() + "' inspect " + arguments + "; code=$?; kill $writer; rm port; exit $code");
  };
  const auto begin = std::chrono::steady_clock::now();
  const CommandResult whole = run_shell(folder, "cat log.csv | '" + command_path() + "' inspect - --json");
  ASSERT_EQ(whole.exit_code, 0) << whole.errors;
  EXPECT_THAT(whole.output, Not(HasSubstr("did not end")));
  const std::string rows = whole.output.substr(whole.output.find("\"rows\""), 20);
  for (const char* input : {"- < port", "port"}) {
    const CommandResult left = run(std::string("--for 1 --json ") + input);
    EXPECT_EQ(left.exit_code, 0) << left.errors;
    EXPECT_THAT(left.output, HasSubstr("did not end within 1 s: what came later is not looked at (--for SECONDS looks longer)"));
    EXPECT_THAT(left.output, HasSubstr(rows)) << "the cut row is left out";
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60)) << "the writer would stay for 100 s";
  EXPECT_EQ(run("port --for 1 -o session.toml").exit_code, 2) << "a session cannot name what is gone";
}

TEST(InspectCommand, AStreamThatSaysNothingIsAnError) {
  const TemporaryFolder folder;
  const CommandResult result = run_shell(folder, "mkfifo port; sleep 100 > port 2>&1 & writer=$!; '" + command_path() +
                                                     "' inspect - --for 0.5 < port; code=$?; kill $writer; exit $code");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("imulab: standard input: no line in 0.5 s; expected rows of numbers"));
}

}  // namespace
}  // namespace imulab
