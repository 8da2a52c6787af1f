// What is given to `inspect`: a log with the record of a receiver, files one after the other, a session, a result, a log in one attitude.
#include "imulab/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <cmath>
#include <string>

namespace imulab {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A still log along a direction of gravity: white noise by a repeated pattern that no reading shares with the next.
std::string still_log(double begin_s, const std::array<double, 3>& force, int rows = 1200, double drift = 0) {
  std::string text = drift == 0 ? "t,ax,ay,az,gx,gy,gz\n" : "t,ax,ay,az,gx,gy,gz,temperature\n";
  std::uint32_t state = 1;
  const auto noise = [&] {
    state = state * 1664525 + 1013904223;
    return static_cast<double>(state >> 8) / (1 << 24) - 0.5;
  };
  for (int i = 0; i < rows; ++i) {
    text += fmt::format("{:.2f}", begin_s + 0.01 * i);
    for (const double a : force) text += fmt::format(",{:.4f}", a + 0.03 * noise());
    for (int k = 0; k < 3; ++k) text += fmt::format(",{:.5f}", 0.01 + drift * i / rows + 0.002 * noise());
    text += drift == 0 ? "\n" : fmt::format(",{:.2f}\n", -10 + 50.0 * i / rows);
  }
  return text;
}

TEST(GivenFiles, ASavedResultIsNamedWithTheVerbsThatTakeIt) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_LE(run_imulab(folder, "calibrate session --method handheld -o calibration.json").exit_code, 1);
  for (const std::string verb : {"inspect calibration.json", "calibrate calibration.json --method static", "noise calibration.json"})
    EXPECT_THAT(on_one_line(run_imulab(folder, verb).errors),
                AllOf(HasSubstr("calibration.json: is a calibration ("),
                      HasSubstr("method handheld), which compensate, compare, export, navigate, report and "
                                "verify take; expected a recording")))
        << verb;
}

TEST(GivenFiles, OneFaceEachAreOneSession) {
  const TemporaryFolder folder;
  std::string names;
  for (int k = 0; k < 6; ++k) {
    std::array<double, 3> force{0.1, -0.2, 0.05};
    force[static_cast<std::size_t>(k / 2)] += k % 2 == 0 ? 9.8 : -9.8;
    folder.write(fmt::format("face{}.csv", k), still_log(k % 2 == 0 ? 0 : 1000.0 * k, force));  // some begin anew
    names += fmt::format(" face{}.csv", k);
  }
  const CommandResult found = run_imulab(folder, "inspect" + names + " --set gyro.unit=rad/s -o session.toml");
  ASSERT_EQ(found.exit_code, 0) << found.errors;
  EXPECT_THAT(on_one_line(found.output),
              AllOf(HasSubstr("files: 6 with the same columns: recordings of one unit one after the other"), HasSubstr("rests: 6 found"),
                    HasSubstr("static no 6 rests, 6 of 9 parameters"), HasSubstr("7200 rows")));
  EXPECT_EQ(read_session(folder / "session.toml").recordings.size(), 6U);
  const std::string by_name = run_imulab(folder, "calibrate" + names + " --method static --set gyro.unit=rad/s").output;
  const std::string by_session = run_imulab(folder, "calibrate session.toml --method static").output;
  EXPECT_THAT(by_session, HasSubstr("accel.offset.x"));
  EXPECT_EQ(by_session.substr(by_session.find("accel.offset.x")), by_name.substr(by_name.find("accel.offset.x")));
}

TEST(GivenFiles, ALogAndItsReceiverAreASessionWithTheAid) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "trajectory '" IMULAB_SOURCE "/tests/portable/drive.toml' --errors -o drive").exit_code, 0);
  const std::string given = "inspect drive/recording.csv drive/gnss_1.csv --set gyro.unit=rad --set gyro.output=increment";
  const CommandResult found = run_imulab(folder, given + " -o drive/found.toml");
  ASSERT_EQ(found.exit_code, 0) << found.errors << found.output;
  EXPECT_THAT(on_one_line(found.output), AllOf(HasSubstr("--method drive"), HasSubstr("aid: gnss_1.csv: gnss, "), HasSubstr("navigate --aided")));
  const Session session = read_session(folder / "drive/found.toml");
  ASSERT_EQ(session.aids.size(), 1U);
  EXPECT_EQ(session.aids[0].file, "gnss_1.csv");
  EXPECT_FALSE(session.site.given_gravity) << "the receiver tells the place";
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect drive/gnss_1.csv").errors), HasSubstr("gnss_1.csv: is an aid of kind gnss and no recording"));
}

TEST(GivenFiles, ASessionIsOpened) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  folder.write("other.csv", still_log(0, {0, 0, 9.8}));
  for (const std::string given : {"session", "session/session.toml", "session/session.toml session/recording.csv"}) {
    const CommandResult opened = run_imulab(folder, "inspect " + given);
    EXPECT_EQ(opened.exit_code, 0) << given << opened.errors << opened.output;
    EXPECT_THAT(on_one_line(opened.output), AllOf(testing::StartsWith("understood: calibrate with --method static or --method handheld"),
                                                  HasSubstr("session: 1 recording, "), Not(HasSubstr("not saved"))))
        << given;
  }
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect session/session.toml other.csv").errors),
              HasSubstr("other.csv: is not named by session/session.toml"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect session -o new.toml").errors), HasSubstr("-o: session/session.toml is a session already"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect session --set rate_hz=100").errors), HasSubstr("session/session.toml: declares all itself"));
}

TEST(GivenFiles, ALogInOneAttitudeIsSaidToBeGoodForSomething) {
  const TemporaryFolder folder;
  folder.write("warm.csv", still_log(0, {0.1, -0.2, 9.8}, 6000, 0.02));
  folder.write("still.csv", still_log(0, {0.1, -0.2, 9.8}));
  const CommandResult warm = run_imulab(folder, "inspect warm.csv --set gyro.unit=rad/s"),
                      still = run_imulab(folder, "inspect still.csv --set gyro.unit=rad/s");
  EXPECT_THAT(on_one_line(warm.output),
              AllOf(HasSubstr("good for: how the zeros follow the temperature in this one attitude: from -10 to 40 degC the means"),
                    HasSubstr("gx +0.018 rad/s")));  // 0.9 of 0.02: between the means of the outer tenths
  EXPECT_THAT(on_one_line(still.output), HasSubstr("good for: noise, as a log at rest in one attitude"));
  // White noise of a uniform distribution: 0.002/sqrt(12) rad/s at 100 Hz.
  const std::string asked = on_one_line(run_imulab(folder, "inspect still.csv").output);
  EXPECT_THAT(asked, HasSubstr("? gyro.unit"));
  EXPECT_THAT(asked, AllOf(HasSubstr("deg/s gives N 0.0035 deg/sqrt(h)"), HasSubstr("rad/s gives N 0.2 deg/sqrt(h)")));
}

}  // namespace
}  // namespace imulab
