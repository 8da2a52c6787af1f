// Messages that advise are tested by doing what they say; logs as people bring them.
#include "imulab/coefficient.hpp"
#include "imulab/files.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/still_log.hpp"
#include <cmath>
#include <regex>

namespace imulab {
namespace {

using ::testing::HasSubstr;

/// A log at rest with stamps of one's own.
void write_log(const TemporaryFolder& folder, int rows, const std::function<std::string(int)>& stamp, const char* name = "log.csv") {
  std::string text = "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < rows; ++i) {
    text += stamp(i);
    for (const double value : still_readings(i)) text += fmt::format(",{:.9g}", value);
    text += '\n';
  }
  folder.write(name, text);
}

/// N of gyro.x that `noise` prints [deg/sqrt(h)].
double white_noise(const std::string& output) {
  std::smatch found;
  return std::regex_search(output, found, std::regex("gyro.x +N +([0-9.]+)")) ? std::stod(found[1]) : 0;
}

/// The options that a message advises: "--time none --rate 158.7".
std::string advised_options(const std::string& errors) {
  const std::string line = on_one_line(errors);
  std::smatch found;
  return std::regex_search(line, found, std::regex("--time none --rate [0-9.]+")) ? found[0].str() : "";
}

double true_noise(double rate_hz) { return 1e-3 / std::sqrt(3 * rate_hz) * 180 / M_PI * 60; }

TEST(Advice, OfARateThatWandersIsEqualSpacing) {
  const TemporaryFolder folder;
  double t = 0;
  write_log(folder, 12'000, [&](int i) { return t += 0.0063 * (1 + 0.04 * std::sin(5e-4 * i)), fmt::format("{:.0f}", 1e3 * t); });
  const CommandResult refused = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s --set time.unit=ms");
  ASSERT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("the rate changes"));
  const std::string options = advised_options(refused.errors);
  const CommandResult taken = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s " + options);
  ASSERT_EQ(taken.exit_code, 0) << options << taken.errors;
  EXPECT_NEAR(white_noise(taken.output) / true_noise(12'000 / t), 1, 0.02);
  const CommandResult session = run_imulab(folder, "inspect log.csv --set gyro.unit=rad/s " + options + " -o s.toml");
  ASSERT_EQ(session.exit_code, 0) << session.errors;
  EXPECT_THAT(read_text(folder / "s.toml"), HasSubstr("time = { unit = \"sample\" }"));
  EXPECT_EQ(run_imulab(folder, "noise s.toml").exit_code, 0) << "although the file has a column of stamps";
}

TEST(Advice, OfStampsThatRepeatIsEqualSpacing) {
  const TemporaryFolder folder;
  write_log(folder, 6000, [](int i) { return fmt::format("{:.2f}", 100 + i / 102.3); });
  const CommandResult taken = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s --verbose");
  ASSERT_EQ(taken.exit_code, 0) << taken.errors;
  EXPECT_THAT(on_one_line(taken.errors), HasSubstr("stamps are on two rows with different readings"));
  EXPECT_NEAR(white_noise(taken.output) / true_noise(102.3), 1, 0.02);
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[[recording]]\nfile = \"log.csv\"\n"
               "time = { column = \"t\", unit = \"s\" }\n"
               "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"rad/s\" }\n"
               "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n");
  const CommandResult declared = run_imulab(folder, "noise session.toml");
  EXPECT_EQ(declared.exit_code, 2);
  EXPECT_THAT(on_one_line(declared.errors), HasSubstr("--time none --rate HZ"));
}

TEST(Advice, ForARateBesideStampsIsNoStamps) {
  const TemporaryFolder folder;
  write_log(folder, 6000, [](int i) { return fmt::format("{:.2f}", 0.01 * i); });
  const CommandResult refused = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s --rate 100");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(on_one_line(refused.errors), HasSubstr("--time none"));
  EXPECT_EQ(run_imulab(folder, "noise log.csv --set gyro.unit=rad/s --rate 100 --time none").exit_code, 0);
}

TEST(Advice, OfTheNearestNameWorks) {
  const TemporaryFolder folder;
  write_log(folder, 6000, [](int i) { return fmt::format("{:.2f}", 0.01 * i); });
  const struct {
    const char *typed, *meant;
  } rows[] = {{"nosie log.csv", "did you mean noise?"},
              {"noise log.csv --devation allan", "did you mean --deviation?"},
              {"noise log.csv --deviation alan", "did you mean allan?"},
              {"noise log.csv --set gyro.units=rad/s", "did you mean gyro.unit?"},
              {"noise log.csv --set gyro.columns=gx,gy,gzz", "did you mean gz?"},
              {"calibrate log.csv --method sttic", "did you mean static?"},
              {"calibrate log.csv --method hand", "--method: hand is not allowed; did you mean handheld?"},
              {"calibrate log.csv --method static --out c.json", "--out is not an option of imulab calibrate; did you mean --output?"},
              {"export c.json --to kalibr-imu --rate 200", "--rate is not an option of imulab export; did you mean --stream-rate?"},
              {"plan --time 600", "--time is not an option of imulab plan; did you mean --within?"},
              {"predict p.toml --monte-carlo 9", "did you mean --runs?"},
              {"noise log.csv --set latitude=45", "--set: latitude is not a key; did you mean latitude_deg?"},
              {"procedure zhang", "zhang is not a procedure; did you mean zhang-24?"},
              {"calibrate --method static", "session is required; usage: imulab calibrate SESSION"},
              {"fleet", "usage: imulab fleet COMMAND"},
              {"export c.json --to kalbr", "did you mean kalibr?"}};
  for (const auto& row : rows) {
    const CommandResult result = run_imulab(folder, row.typed);
    EXPECT_EQ(result.exit_code, 2) << row.typed;
    EXPECT_THAT(on_one_line(result.errors), HasSubstr(row.meant)) << row.typed;
  }
}

TEST(OneTriad, IsEnoughForNoise) {
  const TemporaryFolder folder;
  write_log(folder, 6000, [](int i) { return fmt::format("{:.2f}", 0.01 * i); });
  for (const auto& [triad, unit, other] : {std::tuple{"gyro", "rad/s", "accel.x"}, {"accel", "m/s^2", "gyro.x"}}) {
    folder.write("one.toml", fmt::format("format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[[recording]]\nfile = \"log.csv\"\n"
                                         "time = {{ column = \"t\", unit = \"s\" }}\n{} = {{ columns = [{}], output = \"rate\", unit = \"{}\" }}\n",
                                         triad, triad[0] == 'g' ? "2, 3, 4" : "5, 6, 7", unit));
    const CommandResult result = run_imulab(folder, "noise one.toml");
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.output, HasSubstr(fmt::format("{}.x", triad)));
    EXPECT_THAT(result.output, testing::Not(HasSubstr(other)));
    EXPECT_EQ(run_imulab(folder, "calibrate one.toml --method handheld").exit_code, 2);
  }
}

TEST(OneTriad, OfAccelerometersIsEnoughForStatic) {
  const TemporaryFolder folder;
  for (const char* made : {"procedure handheld --poses 20 -o hand.toml", "simulate hand.toml -o made"})
    ASSERT_EQ(run_imulab(folder, made).exit_code, 0);
  ASSERT_EQ(run_shell(folder, "sed '/^gyro = /d; /^\\[\\[step/,$d' made/session.toml > made/accel.toml").exit_code, 0);
  const CommandResult alone = run_imulab(folder, "calibrate made/accel.toml --method static -o alone.json --verbose --report alone.html");
  ASSERT_EQ(alone.exit_code, 0) << alone.errors << alone.output;
  EXPECT_THAT(on_one_line(alone.output), HasSubstr("the gyros were not calibrated: the recording has none"));
  ASSERT_EQ(run_imulab(folder, "calibrate made --method static -o both.json").exit_code, 0);
  const Calibration one = read_calibration(folder / "alone.json"), both = read_calibration(folder / "both.json");
  for (const CoefficientIndex index : select_coefficients("accel.offset"))
    EXPECT_NEAR(coefficient_value(one.model, index), coefficient_value(both.model, index), *standard_uncertainty(both, index));
  for (const char* refused : {"calibrate made/accel.toml --method handheld", "compensate alone.json made/accel.toml -o x.csv"}) {
    const CommandResult result = run_imulab(folder, refused);
    EXPECT_EQ(result.exit_code, 2) << refused;
    EXPECT_THAT(on_one_line(result.errors), HasSubstr("has no gyros")) << refused;
  }
}

TEST(RepeatedReadings, AreLeftOutAndSaid) {
  const TemporaryFolder folder;
  write_still_log(folder, 20'000, [](int i) { return still_readings(repeated_noise(i / 9, 9) > 0.7 ? i / 9 * 9 : i); });
  const CommandResult result = run_imulab(folder, "noise session.toml");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.errors), HasSubstr("% of the rows repeat the readings of the row before at a new stamp"));
  EXPECT_NEAR(white_noise(result.output) / true_noise(100), 1, 0.02);
}

}  // namespace
}  // namespace imulab
