// Logs as people bring them, with what is right (shared/cases/README.md). They are not part of the project.
// ctest: once
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace imulab {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::filesystem::path cases = std::filesystem::path(IMULAB_SOURCE) / ".." / "shared" / "cases";

class Cases : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(cases)) GTEST_SKIP() << "the logs are not here: " << cases;
    std::filesystem::create_directory_symlink(std::filesystem::canonical(cases), folder_ / "cases");
  }
  CommandResult run(const std::string& arguments) { return run_imulab(folder_, arguments); }
  /// White noise of gyro x (axis 0) [deg/sqrt(h)] or accelerometer z (5) [ug/sqrt(Hz)].
  double noise_of(const std::string& arguments, std::size_t axis = 0) {
    const double unit = axis < 3 ? unit::deg_per_sqrt_h : unit::ug_per_sqrt_hz;
    const CommandResult result = run("noise --json " + arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    if (result.exit_code != 0) return 0;
    return nlohmann::json::parse(result.output).at("axes").at(axis).at("coefficients").at("N").at("value").get<double>() / unit;
  }

  TemporaryFolder folder_;
};

TEST_F(Cases, NoiseIsThatOfTheSensor) {
  constexpr double statistical = 0.04;  // of N: two standard deviations in a minute
  const auto near = [&](double right) { return testing::DoubleNear(right, statistical * right); };
  EXPECT_THAT(noise_of("cases/xsens_ticks/mt.txt --set gyro.unit=rad/s"), near(0.481));
  EXPECT_THAT(noise_of("cases/same_names/Gyroscope.csv --set gyro.unit=rad/s"), near(0.309));
  EXPECT_THAT(noise_of("cases/frozen/frozen.csv --set gyro.unit=rad/s"), near(0.300));
  EXPECT_THAT(noise_of("cases/frozen/frozen.csv --set gyro.unit=rad/s", 5), near(150));
  EXPECT_THAT(noise_of("cases/stamps_deadend/loop.csv --set gyro.unit=rad/s --time none --rate 158.7"), near(0.2385));
  EXPECT_GT(noise_of("cases/one_triad/gyro.csv --set gyro.unit=rad/s"), 0);
  EXPECT_THAT(run("noise cases/stamps_deadend/loop.csv --set gyro.unit=rad/s").errors, HasSubstr("--time none --rate 158.7"));
  EXPECT_EQ(run("noise cases/moving_noise/fly.csv").exit_code, 1);
}

TEST_F(Cases, AreUnderstoodOrAskOneQuestion) {
  for (const char* understood :
       {"decimal_comma/m_Gyroscope.csv cases/decimal_comma/m_Accelerometer.csv", "unit_row/unitrow.csv", "unit_row/label_header_units.csv",
        "small_tilt/robot_units.csv", "zyx/Gyroscope.csv cases/zyx/TotalAcceleration.csv", "one_triad/accel.csv"})
    EXPECT_EQ(run(std::string("inspect cases/") + understood).exit_code, 0) << understood;
  for (const char* gyro_unit : {"xsens_ticks/mt.txt", "same_names/Accelerometer.csv cases/same_names/Gyroscope.csv", "long_line/cr_4000.csv",
                                "small_tilt/robot.csv", "blank_fields/blank8.csv", "utf16/utf16.csv", "stamps_deadend/five_digits.csv"})
    EXPECT_THAT(run(std::string("inspect cases/") + gyro_unit).output, HasSubstr("open: 1 question that the data do not answer; declare with --set "
                                                                                 "KEY=VALUE\n  ? gyro.unit"))
        << gyro_unit;
}

TEST_F(Cases, AreReadByNameOrAskOneQuestion) {
  const auto asked = [&](const std::string& arguments, const std::string& question) {
    EXPECT_THAT(run("inspect cases/" + arguments).output,
                HasSubstr("open: 1 question that the data do not answer; declare with --set KEY=VALUE\n  ? " + question))
        << arguments;
  };
  asked("triad_across_two_sensors/two_gyros.csv", "gyro.columns: 2 pairs");
  asked("triad_across_two_sensors/ronin.hdf5", "gyro.columns: 2 pairs");
  asked("slow_accelerometer_still/acc63_gyr200.csv", "gyro.unit");
  asked("rate_against_the_stamps/pairs.csv", "gyro.unit");
  asked("numbers_as_header/pandas.csv", "accel.columns, gyro.columns");
  EXPECT_THAT(run("inspect cases/rate_against_the_stamps/pairs.csv --rate 200").errors,
              HasSubstr("rate_hz = 200: the stamps of timestamp give 100 Hz"));
  EXPECT_NEAR(noise_of("cases/rate_against_the_stamps/pairs.csv --set gyro.unit=rad/s"), 0.299, 0.04 * 0.299);
  EXPECT_THAT(run("noise cases/slow_accelerometer_still/acc63_gyr200.csv --set gyro.unit=rad/s").errors,
              testing::AllOf(HasSubstr("accelerometers every 0.015873 s"), Not(HasSubstr("repeat")), Not(HasSubstr("spectrum"))));
}

TEST_F(Cases, AreTheSameMotion) {
  struct Log {
    std::string files, declared;
  };
  for (const Log& log :
       std::vector<Log>{{"base/base.csv", ""},
                        {"axis_in_parentheses/accl.csv cases/axis_in_parentheses/gyro.csv", ""},
                        {"gravity_taken_as_accelerometer/androsensor.csv", ""},
                        {"gravity_taken_as_accelerometer/devicemotion.csv", ""},
                        {"triad_across_two_sensors/two_gyros.csv", "--set gyro.columns=gyro_uncalib.x,gyro_uncalib.y,gyro_uncalib.z"},
                        {"lost_samples/lost.csv", ""},
                        {"receipt_stamp_before_header_stamp/imu.csv", ""},
                        {"unit_in_parentheses/shimmer.csv", ""}}) {
    ASSERT_EQ(run("inspect cases/" + log.files + " " + log.declared + " --set latitude_deg=45 -o moved.toml --force").exit_code, 0) << log.files;
    ASSERT_EQ(run("calibrate moved.toml --method handheld --effects none -o moved.json --force").exit_code, 0) << log.files;
    const auto offset = nlohmann::json::parse(read_text(folder_ / "moved.json")).at("model").at("accel").at("offset");
    constexpr double mg = 1e-3 * unit::g, usual = 0.5, right[] = {34.26, 30.34, 11.41};  // as the plain log has them, at any latitude
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(offset.at(axis).get<double>() / mg, right[axis], usual) << log.files << axis;
  }
  EXPECT_EQ(run("inspect cases/trembling_pauses/pauses.csv --set latitude_deg=45 -o pauses.toml").exit_code, 0);
  EXPECT_THAT(run("calibrate pauses.toml --method static --effects none").output, testing::ContainsRegex("accel.offset.x +34.[1-7]"));
  EXPECT_EQ(run("inspect cases/zero_of_half_a_g/counts.csv -o counts.toml").exit_code, 0);
  EXPECT_EQ(run("inspect cases/no_stamps/accel-0.csv cases/no_stamps/gyro-0.csv --rate 100 --set gyro.unit=rad/s -o rows.toml").exit_code, 0);
}

TEST_F(Cases, LiveAndInspectionAnswerAlike) {
  const auto live = [&](const std::string& folder, const std::string& file) {
    return run_shell(folder_, "cat cases/" + folder + "/" + file + " | " + command_path() + " live - --session cases/" + folder +
                                  "/session.toml -o " + folder + ".json");
  };
  const CommandResult phone = live("rounded_phone", "phone.csv");
  EXPECT_THAT(phone.output, HasSubstr("25 rests in 190 s"));
  EXPECT_THAT(run("inspect cases/rounded_phone/phone.csv").output, HasSubstr("rests: 25 found"));
  // Misalignments are not yet as certain as is required by default, but the calibration is that of `calibrate`.
  EXPECT_THAT(live("live_answers", "live.csv").output, HasSubstr("8 rests in 67 s: good; written: live_answers.json"));
  EXPECT_THAT(run("inspect cases/live_answers/live.csv").output, testing::ContainsRegex("handheld +yes +8 rests"));
  EXPECT_EQ(run("calibrate cases/live_answers/session.toml --method handheld -o calibrated.json").exit_code, 0);
  const auto model_of = [&](const char* file) { return nlohmann::json::parse(read_text(folder_ / file)).at("model"); };
  EXPECT_EQ(model_of("live_answers.json"), model_of("calibrated.json"));
}

TEST_F(Cases, AHangingGyroIsNamed) {
  const std::string named = "gyro.x repeats one reading for up to 8 samples, 25 times";
  EXPECT_THAT(run("inspect cases/stuck_in_turns/stuck.csv -o stuck.toml").output, HasSubstr(named));
  run("calibrate stuck.toml --method handheld -o stuck.json");
  EXPECT_NE(nlohmann::json::parse(read_text(folder_ / "stuck.json")).at("quality").at("because").dump().find(named), std::string::npos);
}

TEST_F(Cases, CalibrationsHaveTheirOffsets) {
  ASSERT_EQ(run_shell(folder_, "cp cases/zyx/*.csv cases/one_triad/accel.csv . && chmod u+w *.csv").exit_code, 0);
  ASSERT_EQ(run("inspect Gyroscope.csv TotalAcceleration.csv --set latitude_deg=45 -o zyx.toml").exit_code, 0);
  ASSERT_EQ(run("inspect accel.csv --set latitude_deg=45 -o alone.toml").exit_code, 0);
  for (const std::string name : {"zyx", "alone"}) {  // the same motion
    ASSERT_EQ(run("calibrate " + name + ".toml --method static --effects none -o " + name + ".json").exit_code, 0) << name;
    const auto offset = nlohmann::json::parse(read_text(folder_ / (name + ".json"))).at("model").at("accel").at("offset");
    constexpr double mg = 1e-3 * unit::g, four_sigma = 0.4;  // of 0.08 mg, and what a latitude of 45 degrees may be off
    EXPECT_NEAR(offset.at(0).get<double>() / mg, 34.28, four_sigma) << name;
    EXPECT_NEAR(offset.at(2).get<double>() / mg, 11.33, four_sigma) << name;
  }
  const CommandResult faces = run("inspect cases/six_files/*.csv --set gyro.unit=rad/s");
  EXPECT_EQ(faces.exit_code, 0) << faces.errors;
  EXPECT_THAT(faces.output, HasSubstr("static     no   6 rests, 6 of 9 parameters"));
  EXPECT_THAT(run("inspect cases/one_attitude_sweep/warm.csv --set time.unit=s --set gyro.unit=rad/s").output,
              HasSubstr("good for: how the zeros follow the temperature in this one attitude: from -10"));
  const CommandResult six = run("calibrate cases/six_files/*.csv --method static --set gyro.unit=rad/s");
  EXPECT_EQ(six.exit_code, 1) << "six directions determine no misalignments";
  EXPECT_THAT(six.output, HasSubstr("accel.offset.x"));
}

TEST_F(Cases, OffsetsThatFollowTheTemperatureAreNamed) {
  ASSERT_EQ(run("calibrate cases/hand_temperature/hand.csv --method handheld --set gyro.unit=rad/s -o t.json").exit_code, 0);
  const auto calibration = nlohmann::json::parse(read_text(folder_ / "t.json"));
  for (const auto& effect : calibration.at("quality").at("effects")) {
    const std::string name = effect.at("name");
    if (name == "gyro.drift" || name == "gyro.offset_temperature") EXPECT_EQ(effect.at("significant"), name == "gyro.offset_temperature") << name;
  }
}

}  // namespace
}  // namespace imulab
