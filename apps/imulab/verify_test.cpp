// Where a calibration comes from, and whether that is still there.
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"

#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;

const std::string calibrate = "calibrate session -o c.json --method handheld";

TEST(VerifyCommand, KnowsTheFilesOfACalibration) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.declare("[imu]\n", "[imu]\nserial = \"012\"\n");
  text.declare("format = \"imulab.session/1\"\n", "format = \"imulab.session/1\"\noperator = \"A. Person\"\n");
  text.write(folder);
  ASSERT_EQ(run_imulab(folder, calibrate).exit_code, 0);
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_EQ(c.serial, "012");
  EXPECT_EQ(c.operated_by, "A. Person");
  EXPECT_EQ(c.options.at("terms"), "auto");
  ASSERT_EQ(c.sources.size(), 1u);
  EXPECT_EQ(c.sources[0].file, "recording.csv");
  EXPECT_EQ(c.sources[0].bytes, std::filesystem::file_size(folder / "session/recording.csv"));
  EXPECT_THAT(run_shell(folder, "sha256sum session/recording.csv").output, testing::StartsWith(c.sources[0].sha256));
  EXPECT_DOUBLE_EQ(c.sources[0].first_s, 0.01);

  const CommandResult same = run_imulab(folder, "verify c.json");
  EXPECT_EQ(same.exit_code, 0) << same.errors;
  EXPECT_THAT(same.output, HasSubstr("session/recording.csv: unchanged"));
  ASSERT_EQ(run_shell(folder, "mv session elsewhere").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "verify c.json --session-at elsewhere").exit_code, 0);
  const CommandResult gone = run_imulab(folder, "verify c.json");
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.output, HasSubstr("session/recording.csv: missing"));
  ASSERT_EQ(run_shell(folder, "mv elsewhere session && echo 1e9,0,0,0,0,0,0 >> session/recording.csv").exit_code, 0);
  const CommandResult changed = run_imulab(folder, "verify c.json");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_THAT(changed.output, HasSubstr("session/recording.csv: changed"));
  EXPECT_THAT(changed.output, HasSubstr("session/session.toml: unchanged"));
}

TEST(VerifyCommand, ADoubtfulCalibrationStaysDoubtful) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_EQ(run_imulab(folder, calibrate).exit_code, 0);
  ASSERT_EQ(
      run_shell(folder, "sed -i 's/\"verdict\": \"good\"/\"verdict\": \"doubtful\"/; s/\"because\": \\[\\]/\"because\": [\"a reason\"]/' c.json")
          .exit_code,
      0);
  const CommandResult verified = run_imulab(folder, "verify c.json");
  EXPECT_EQ(verified.exit_code, 0) << "the files are unchanged";
  EXPECT_THAT(on_one_line(verified.output),
              testing::StartsWith("doubtful: 2 of 2 files are unchanged; the calibration itself is doubtful: a reason"));
}

TEST(CalibrateCommand, ReplacesACalibrationOnlyByForce) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  folder.write("c.json", "the work of hours");
  const CommandResult refused = run_imulab(folder, calibrate);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("-o c.json: exists; expected a new file, or --force to replace it"));
  EXPECT_EQ(read_text(folder / "c.json"), "the work of hours");
  EXPECT_EQ(run_imulab(folder, calibrate + " --force").exit_code, 0);
  EXPECT_NE(read_text(folder / "c.json"), "the work of hours");
}

TEST(CalibrateCommand, SaysThatNothingWasSaved) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  EXPECT_THAT(run_imulab(folder, "calibrate session --method handheld").output, HasSubstr("not saved: no -o FILE was given"));
}

TEST(CalibrateCommand, JudgesItsPurpose) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  const CommandResult met = run_imulab(folder, calibrate + " --require 'gyro.matrix.diagonal <= 1 %, accel.offset <= 100 mg'");
  EXPECT_EQ(met.exit_code, 0) << met.errors;
  EXPECT_THAT(met.output, HasSubstr("gyro.matrix.diagonal <= 1 %: met (gyro.matrix."));
  const CommandResult missed = run_imulab(folder, calibrate + " --force --require 'gyro.matrix.diagonal <= 1 ppm, accel.offset <= 100 mg'");
  EXPECT_EQ(missed.exit_code, 1);
  EXPECT_THAT(missed.errors, HasSubstr("not reached: gyro.matrix.diagonal <= 1 ppm"));
  const Quality quality = read_calibration(folder / "c.json").quality;  // written all the same
  ASSERT_EQ(quality.requirements.size(), 2u);
  EXPECT_FALSE(quality.requirements[0].met);
  EXPECT_GT(quality.requirements[0].reached, 1e-6);
  EXPECT_TRUE(quality.requirements[1].met);
  EXPECT_EQ(quality.verdict, Verdict::good);  // the data are consistent; that they are not enough is another matter
}

TEST(UndeterminedCalibration, IsNotUsedByItself) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.write(folder, "whole");
  text.lines.resize(1 + 3500);  // two rests
  text.write(folder);
  ASSERT_EQ(run_imulab(folder, calibrate).exit_code, 1);
  for (const std::string verb : {"compensate c.json whole -o out.csv", "export c.json --to c-header -o c.h", "navigate c.json whole --align"}) {
    const CommandResult refused = run_imulab(folder, verb);
    EXPECT_EQ(refused.exit_code, 1) << verb;
    EXPECT_THAT(refused.errors, HasSubstr("c.json: the data did not determine ")) << verb;
  }
  const CommandResult allowed = run_imulab(folder, "compensate c.json whole -o out.csv --allow-undetermined");
  EXPECT_EQ(allowed.exit_code, 0) << allowed.errors;
  EXPECT_THAT(allowed.errors, HasSubstr("imulab: warning: c.json: the data did not determine "));
}

TEST(SerialNumbers, ThatDifferAreComparedOnlyIfThatIsMeant) {
  const TemporaryFolder folder;
  for (const std::string serial : {"1", "2"}) {
    SessionText text = hand_held_session();
    text.declare("[imu]\n", "[imu]\nserial = \"" + serial + "\"\n");
    text.write(folder, "s" + serial);
    ASSERT_EQ(run_imulab(folder, "calibrate s" + serial + " --method handheld -o " + serial + ".json").exit_code, 0);
  }
  const CommandResult refused = run_imulab(folder, "compare 1.json 2.json");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("expected calibrations of one IMU, or that different IMUs are allowed"));
  EXPECT_EQ(run_imulab(folder, "compare 1.json 2.json --different-imus").exit_code, 0);
}

}  // namespace
}  // namespace imulab
