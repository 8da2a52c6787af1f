// What is wrong with the command or an input file: exit code 2, a message with file, line and field, and no output file.
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <cstdio>
#include <functional>

namespace imulab {
namespace {

using ::testing::HasSubstr;

struct Case {
  std::function<void(SessionText&)> damage;
  std::string message;
};

void expect_refused(const TemporaryFolder& folder, const std::string& arguments, const std::string& message) {
  SCOPED_TRACE(arguments);
  const CommandResult result = run_imulab(folder, arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("imulab: " + message));
  EXPECT_EQ(result.output, "");
}

/// Both methods refuse each damaged session with the message, and leave no file.
void expect_each_refused(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    c.damage(text);
    text.write(folder);
    for (const char* method : {"handheld", "static"})
      expect_refused(folder, std::string("calibrate session -o c.json --method ") + method, c.message);
    EXPECT_FALSE(std::filesystem::exists(folder / "c.json")) << c.message;
  }
}

TEST(BadInput, ARecordingNamesFileLineAndColumn) {
  const std::string file = "session/recording.csv";
  expect_each_refused({
      {[](SessionText& s) { s.declare("\"recording.csv\"", "\"other.csv\""); }, "session/other.csv: cannot be opened: No such file"},
      {[](SessionText& s) { s.declare("\"recording.csv\"", "\".\""); }, "session/.: is a folder; expected a file"},
      {[](SessionText& s) { s.lines.clear(); }, file + ": is empty; expected rows of numbers"},
      {[](SessionText& s) { s.lines.resize(1); }, file + ": has a header but no rows"},
      {[](SessionText& s) { s.lines[0] = "t,gx,gy,gz,ax,ay,up"; }, file + ": column az is not there; expected one of t, gx, gy, gz, ax, ay, up"},
      {[](SessionText& s) { s.set(5, 2, "abc"); }, file + ":5: gy: \"abc\" is not a number"},
      {[](SessionText& s) { s.set(77, 1, "nan"); }, file + ":77: gx: nan is not a reading; expected a finite number"},
      {[](SessionText& s) { s.set(9601, 6, "-inf"); }, file + ":9601: az: -inf is not a reading; expected a finite number"},
      {[](SessionText& s) { s.lines[99] += ",1"; }, file + ":100: 8 fields; expected 7 as in the header"},
      {[](SessionText& s) { s.set(5, 0, "0.015"); }, file + ":5: t: time runs backwards: 0.015 s after 0.03 s"},
      {[](SessionText& s) { s.set(5, 0, "0.03"); }, file + ":5: t: 0.03 s is on two rows with different readings"},
      {[](SessionText& s) { s.declare("rate_hz = 100", "rate_hz = 200"); }, file + ": rate_hz = 200 is declared, but the stamps give 100 Hz"},
      {[](SessionText& s) { s.lines[9] = std::string("\0\1\2\3", 4); }, file + ": unknown format; expected "},
  });
}

TEST(BadInput, AHugeFieldIsQuotedInShort) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.set(3, 1, std::string(1000000, '1'));
  text.write(folder);
  const CommandResult result = run_imulab(folder, "calibrate session --method handheld");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("imulab: session/recording.csv:3: gx: 1111"));
  EXPECT_THAT(result.errors, HasSubstr("is too large or too small; expected a number that a double can hold"));
  EXPECT_LT(result.errors.size(), 200u);
}

TEST(BadInput, UnitsThatTheRestsContradict) {
  expect_each_refused({
      {[](SessionText& s) {
         s.for_rows([](std::vector<double>& row) {
           for (const std::size_t k : {4, 5, 6}) row[k] /= 9.80665;
         });
       },
       "recording.csv: gravity at rest: the accelerometers' scale is"},
      {[](SessionText& s) { s.declare("unit = \"m/s^2\"", "unit = \"g\""); }, "recording.csv: gravity at rest: the accelerometers' scale is"},
      {[](SessionText& s) { s.lines[0] = "t,ax,ay,az,gx,gy,gz"; }, "recording.csv: gravity at rest: the accelerometers' scale is"},
  });
}

TEST(BadInput, ASessionNamesLineAndKey) {
  const std::string file = "session/session.toml";
  expect_each_refused({
      {[](SessionText& s) { s.declare("height_m", "hight_m"); }, file + ":9: site.hight_m: is not a known key; expected height_m"},
      {[](SessionText& s) { s.declare("rad/s", "rpm"); },
       file + ":18: recording.gyro.unit: \"rpm\" is not allowed; expected one of count, rad/s, deg/s, mdeg/s, deg/min, deg/h"},
      {[](SessionText& s) { s.declare("session/1", "session/7"); }, file + ":1: format: \"imulab.session/7\" is a format this version does not know"},
      {[](SessionText& s) { s.declare("[rig]", "[rig"); }, file + ":11: "},
      {[](SessionText& s) { s.session.resize(s.session.find("[[recording]]")); }, file + ": has no recordings; expected at least one [[recording]]"},
      {[](SessionText& s) { s.declare("latitude_deg = 45\n", ""); }, file + ": [site]: neither gravity nor latitude of the site is given"},
  });
}

TEST(BadInput, ACommandThatIsWrong) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  folder.write("file", "");
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"calibarte session", "calibarte is not a command, expected one of demo, help, inspect, calibrate, "},
           {"calibrate", "session is required"},
           {"calibrate session", "--method is required"},
           {"calibrate session --method magic", "--method: magic not in {handheld,hybrid,static,turntable,whole-unit}"},
           {"calibrate session --method static --frobnicate", "The following argument was not expected: --frobnicate"},
           {"calibrate session --method static --terms gyro.ofset", "--terms: unknown coefficient \"gyro.ofset\""},
           {"calibrate session --method static --terms ''", "--terms: unknown coefficient \"\""},
           {"calibrate session --method handheld --terms accel.lever_arm",
            "--terms: accel.lever_arm.xx is not a coefficient that the method handheld estimates"},
           {"calibrate session --method static --recording other.csv",
            "session/session.toml: has no recording other.csv; expected --recording with one of recording.csv"},
           {"calibrate nowhere --method static", "nowhere: cannot be opened: No such file"},
           {"calibrate file --method static", "file: is empty; expected rows of numbers"},
           {"calibrate session --method static -o nowhere/c.json", "nowhere/c.json: cannot be written: No such file"},
           {"calibrate session --method static -o session", "session: cannot be written: Is a directory"},
           {"procedure hand-held -o nowhere/hand.toml", "nowhere/hand.toml: cannot be written: No such file"},
           {"procedure hand-held --poses 0", "hand-held: no poses; expected at least one"},
           {"procedure hand-held --poses 1000000000", "hand-held: 1000000000 poses; expected at most 100000"},
           {"procedure zhang-24 --rest inf", "--rest"},
           {"procedure six-feet", "six-feet is not a procedure, expected one of six-position, zhang-24, cheng-path, hand-held, dai-unit"},
           {"simulate session", "--output is required"},
           {"simulate nowhere.toml -o out", "nowhere.toml: cannot be opened: No such file"},
           {"compensate file session -o out.csv", "file: is empty; expected a calibration"},
       })
    expect_refused(folder, arguments, message);
  for (const char* name : {"nowhere", "out", "out.csv"}) EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
}

TEST(BadInput, ACalibrationFromANewerFormat) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_EQ(run_imulab(folder, "calibrate session --method handheld -o c.json").exit_code, 0);
  std::string newer = read_text(folder / "c.json");
  newer.replace(newer.find("calibration/1"), 13, "calibration/2");
  folder.write("newer.json", newer);
  const std::string message = "newer.json: format: imulab.calibration/2 is a newer format; this program reads imulab.calibration/1";
  expect_refused(folder, "compensate newer.json session -o out.csv", message);
  expect_refused(folder, "compare c.json newer.json", message);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
}

}  // namespace
}  // namespace imulab
