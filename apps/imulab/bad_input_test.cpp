// Faults of the command line or an input file: exit code 2, a message with file, line and field, and no output file.
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <cstdio>
#include <functional>
#include <sys/stat.h>

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
      {[](SessionText& s) { s.lines.clear(); }, file + ": is empty; expected rows of numbers"},
      {[](SessionText& s) { s.lines.resize(1); }, file + ": has a header but no rows"},
      {[](SessionText& s) { s.lines[0] = "t,gx,gy,gz,ax,ay,up"; }, file + ": column az is not there; expected one of t, gx, gy, gz, ax, ay, up"},
      {[](SessionText& s) { s.set(5, 2, "abc"); }, file + ":5: gy: \"abc\" is not a number"},
      {[](SessionText& s) {
         for (std::size_t line = 77; line < 300; ++line) s.set(line, 1, "nan");
       },
       file + ":77: gx: nan is not a reading; expected a finite number"},
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
      {[](SessionText& s) { s.declare("height_m", "hight_m"); }, file + ":9: site.hight_m: is not a known key; did you mean height_m?"},
      {[](SessionText& s) { s.declare("rad/s", "rpm"); },
       file + ":18: recording.gyro.unit: \"rpm\" is not allowed; expected one of count, rad/s, deg/s, mdeg/s, deg/min, deg/h"},
      {[](SessionText& s) { s.declare("session/1", "session/7"); }, file + ":1: format: \"imulab.session/7\" is a format this version does not know"},
      {[](SessionText& s) { s.declare("[rig]", "[rig"); }, file + ":11: "},
      {[](SessionText& s) { s.session.resize(s.session.find("[[recording]]")); }, file + ": has no recordings; expected at least one [[recording]]"},
      {[](SessionText& s) { s.declare("latitude_deg = 45\n", ""); }, file + ": [site]: neither gravity nor latitude of the site is given"},
  });
}

TEST(BadInput, AFolderThatWasDeleted) {
  const TemporaryFolder folder;
  for (const char* arguments : {"demo", "procedure handheld -o hand.toml"}) {
    const CommandResult result = run_shell(folder, "mkdir gone && cd gone && rmdir ../gone && '" + command_path() + "' " + arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.errors, testing::StartsWith("imulab: the current folder is not there any more; expected one that is")) << arguments;
  }
}

TEST(BadInput, ACommandThatIsWrong) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  folder.write("file", "");
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"calibarte session", "calibarte is not a command; did you mean calibrate?"},
           {"calibrate", "session is required; usage: imulab calibrate SESSION"},
           {"calibrate session",
            "--method is required; expected one of drive, handheld, hybrid, reference, static, turntable, whole-unit; usage: imulab calibrate"},
           {"compensate session/recording.csv session -o out.csv",
            "session/recording.csv: is not JSON, but perhaps a recording; expected a calibration; usage: imulab compensate CALIBRATION SESSION"},
           {"export none --noise session/recording.csv --to gtsam",
            "session/recording.csv: is not JSON, but perhaps a recording; expected noise.json as"},
           {"export session/truth.json noise.json --to gtsam",
            "The following argument was not expected: noise.json; did you mean --noise noise.json?"},
           {"predict session",
            "session/session.toml: the rig is of kind \"none\"; the method turntable expects \"turntable\"; without a rig: --method handheld"},
           {"simulate handheld -o out",
            "handheld: is a procedure's name; expected its file, which imulab procedure handheld -o handheld.toml writes"},
           {"calibrate session/recording.csv --method static --set grade=MEMS", "--set: grade = \"MEMS\": unknown; did you mean mems?"},
           {"calibrate session/recording.csv --method static --set latitude_deg=45N", "--set: latitude_deg = 45N: is no number; expected a number"},
           {"noise --datasheet 'gyro.N: 1 deg/h'", "--datasheet: \"gyro.N: 1 deg/h\": expected KEY = NUMBER UNIT"},
           {"noise --datasheet 'gyro.n = 1 deg/sqrt(h)'", "--datasheet: gyro.n: is not a value of a data sheet; did you mean gyro.N?"},
           {"calibrate session --method magic",
            "--method: magic is not allowed; expected one of drive, handheld, hybrid, reference, static, turntable, whole-unit"},
           {"calibrate session --method static --frobnicate", "--frobnicate is not an option of imulab calibrate (--help"},
           {"calibrate session --method static --terms gyro.ofset", "--terms: unknown coefficient \"gyro.ofset\""},
           {"calibrate session --method static --terms ''", "--terms: unknown coefficient \"\""},
           {"calibrate session --method handheld --terms accel.lever_arm",
            "--terms: accel.lever_arm.xx is not a coefficient that the method handheld estimates"},
           {"calibrate session --method static --recording other.csv",
            "--recording: session/session.toml: has no recording other.csv; expected one of recording.csv"},
           {"calibrate nowhere --method static", "nowhere: cannot be opened: No such file"},
           {"calibrate file --method static", "file: is empty; expected rows of numbers"},
           {"calibrate session --method static -o nowhere/c.json", "nowhere/c.json: cannot be written: nowhere is no folder"},
           {"calibrate session --method static -o session", "-o session: is a folder; expected a file to write"},
           {"procedure handheld -o nowhere/hand.toml", "nowhere/hand.toml: cannot be written: nowhere is no folder"},
           {"procedure handheld --poses 0", "handheld: no poses; expected at least one"},
           {"procedure handheld --poses 1000000000", "handheld: 1000000000 poses; expected at most 100000"},
           {"procedure zhang-24 --rest inf", "--rest"},
           {"procedure six-feet",
            "six-feet is not a procedure; expected one of six-position, two-axis, zhang-24, cheng-path, ferraris, handheld, warm-up, dai-unit"},
           {"simulate session", "--output is required"},
           {"simulate nowhere.toml -o out", "nowhere.toml: cannot be opened: No such file"},
           {"compensate file session -o out.csv", "file: is empty; expected a calibration"},
       })
    expect_refused(folder, arguments, message);
  for (const char* name : {"nowhere", "out", "out.csv"}) EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
}

/// Numbers that no use has: nothing is computed, and the message has the option or the key.
TEST(BadInput, NumbersOutOfRange) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"procedure handheld --seed -1", "--seed: -1; expected a whole number from 0"},
           {"procedure handheld --seed 99999999999999999999", "--seed: 99999999999999999999; expected a whole number from 0"},
           {"procedure handheld --poses 1e3", "--poses: 1e3; expected a whole number"},
           {"procedure six-position --rest inf", "--rest: inf; expected a finite number"},
           {"procedure six-position --table inf", "--table: inf; expected a finite number"},
           {"procedure six-position --table -5", "--table: -5; expected a number from 0 to 1296000"},
           {"procedure dai-unit --rate-hz 1e300", "--rate-hz: 1e300; expected a number from 0.1 to 1000000"},
           {"budget m.toml --every nan", "--every: nan; expected a finite number"},
           {"budget m.toml --every 1e-300", "--every: 1e-300; expected a number from 0.001"},
           {"budget m.toml --runs -1", "--runs: -1; expected a whole number"},
           {"inspect session/recording.csv --for nan", "--for: nan; expected a finite number"},
           {"inspect session/recording.csv --set latitude_deg=95", "--set: latitude_deg = 95: is out of range"},
           {"navigate none session --heading nan", "--heading: nan; expected a finite number"},
           {"plan --require 'accel.offset <= 1 mg' --latitude 91", "--latitude: 91; expected "},
           {"predict session --runs 2000000000", "--runs: 2000000000; expected 0, or 100 to 1000000000"},
           {"export c.json --to c-header --accel-counts-per-unit 1e-300", "--accel-counts-per-unit: 1e-300; expected a number from 1e-09 to 1e+12"},
           {"export c.json --to c-header --gyro-range -1", "--gyro-range: -1; expected a number from 1e-09 to 1e+12"},
           {"--threads 0 compare a b", "--threads: 0; expected a whole number from 1 to 1024"},
       })
    expect_refused(folder, arguments, message);
}

struct Declared {
  std::string from, to, message;
};

TEST(BadInput, DeclaredNumbersOutOfRange) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure handheld --poses 12 -o good.toml").exit_code, 0);
  const std::string good = read_text(folder / "good.toml"), rate = "rate_hz = 100", first = "duration_s = 30";
  for (const Declared& d : {
           Declared{rate, "rate_hz = 1e-300", "p.toml:16: recording.rate_hz: 1e-300 is out of range; expected 0.001 to 1000000"},
           Declared{rate, "rate_hz = 1e300", "p.toml:16: recording.rate_hz: 1e+300 is out of range; expected 0.001 to 1000000"},
           Declared{rate, "rate_hz = nan", "p.toml:16: recording.rate_hz: is not finite; expected a finite number"},
           Declared{rate, "rate_hz = 0.001", "p.toml: the steps last less than one sample; expected at least one"},
           Declared{first, "start_s = 1e12\nend_s = 2e12", "p.toml:23: step.start_s: 1000000000000 is out of range; expected -4600000000"},
           Declared{first, "duration_s = 1e12", "p.toml:22: step.kind: hold ends 1e+12 s after the begin; expected at most 4.6e+09"},
           Declared{first, "duration_s = inf", "p.toml:23: step.duration_s: is not finite"},
           Declared{first, "duration_s = 1e9", "p.toml: 1e+11 samples; expected at most 1e+08"},
           Declared{"outer_deg = ", "outer_deg = 1e30 #", "p.toml:25: step.outer_deg: 1e+30 is out of range; expected -1000000 to 1000000"},
           Declared{"latitude_deg = 45", "latitude_deg = 90.5", "p.toml:8: site.latitude_deg: 90.5 is out of range; expected -90 to 90"},
           Declared{"height_m = 0", "height_m = 0\ngravity_sigma_mps2 = -1",
                    "p.toml:10: site.gravity_sigma_mps2: -1 is out of range; expected at least 0"},
           Declared{"height_m = 0", "height_m = 0\ngravity_sigma_mps2 = 1e300", "p.toml:10: site.gravity_sigma_mps2: 1e+300 is out of range"},
       }) {
    std::string text = good;
    ASSERT_NE(text.find(d.from), std::string::npos) << d.from;
    folder.write("p.toml", text.replace(text.find(d.from), d.from.size(), d.to));
    expect_refused(folder, "simulate p.toml -o out", d.message);
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << d.to;
  }
}

TEST(BadInput, MoreThanTheMemoryHolds) {
  if (under_sanitizers()) GTEST_SKIP() << "they take terabytes of addresses";
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure zhang-24 --rest 10000 -o long.toml").exit_code, 0);  // 35 million samples, 2 GB
  const CommandResult result = run_shell(folder, "ulimit -v 1000000; '" + command_path() + "' simulate long.toml -o out");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.errors, "imulab: out of memory; expected less data, or a machine with more memory\n");
  EXPECT_EQ(run_shell(folder, "ls").output, "long.toml\n");
}

TEST(BadInput, WhatIsNoFileOfOurs) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  folder.write("secret", "root:$6$salt:20000:0:99999:7:::\ndaemon:*:20000:0:99999:7:::\n");
  const auto names = [&](const std::string& file) {
    std::string text = hand_held_session().session;
    folder.write("session/other.toml", text.replace(text.find("recording.csv"), 13, file));
    return run_imulab(folder, "calibrate session/other.toml --method handheld");
  };
  const CommandResult secret = names("../secret"), pipe = names("../pipe"), device = names("/dev/zero");
  EXPECT_EQ(secret.errors, "imulab: session/../secret: has no row of numbers; expected CSV or plain columns of numbers\n");
  EXPECT_EQ(pipe.errors, "imulab: session/../pipe: is a pipe or a device; expected a recording that is a file on disk\n");
  EXPECT_EQ(device.errors, "imulab: /dev/zero: is a pipe or a device; expected a recording that is a file on disk\n");
  expect_refused(folder, "calibrate pipe --method handheld", "pipe: nobody writes to this pipe; expected a writer within 5 s");
  expect_refused(folder, "calibrate /dev/zero --method handheld", "/dev/zero: is longer than 64 MiB; expected less");
  expect_refused(folder, "compare - c.json < /dev/zero", "standard input: is longer than 64 MiB; expected less");
  expect_refused(folder, "report - -o page.html < /dev/zero", "standard input: is longer than 64 MiB; expected less");
}

TEST(BadInput, MessagesShowWhatWouldSteerATerminalAndQuoteInShort) {
  const TemporaryFolder folder;
  const std::string site = "[site]\n";
  for (const auto& [key, shown] : {std::pair<std::string, std::string>{"\"" + std::string(20'000'000, 'k') + "\"", std::string(60, 'k') + "..."},
                                   {R"("a\u0000b")", R"(a\x00b)"},
                                   {R"("\u001b[31m")", R"(\x1b[31m)"},
                                   {R"("two\nlines")", R"(two\x0alines)"}}) {
    SessionText text = hand_held_session();
    text.declare(site, site + key + " = 1\n");
    text.write(folder);
    const CommandResult result = run_imulab(folder, "calibrate session --method handheld");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.errors, HasSubstr("imulab: session/session.toml:8: site." + shown + ": is not a known key; expected one of latitude_deg"));
    EXPECT_LT(result.errors.size(), 300u);
  }
  expect_refused(folder, "$(printf 'x\\033[31m')", R"(x\x1b[31m is not a command)");
  expect_refused(folder, "compare \"$(printf '\\033]0;title\\007')\" c.json", R"(\x1b]0;title\x07: cannot be opened)");
  expect_refused(folder, "calibrate session --method \"$(printf '\\033[31m')\"", R"(--method: \x1b[31m is not allowed; expected one of)");
}

TEST(BadInput, NamesOfAnyBytes) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.declare("name = \"handheld\"", "name = \"x\\u001b[31m\\u009b\"");
  text.write(folder);
  const std::string place = "\"$(printf 'odd\\377')\"";
  ASSERT_EQ(run_shell(folder, "mv session " + place).exit_code, 0);
  const CommandResult result = run_imulab(folder, "calibrate " + place + " --method handheld -o c.json --report " + place + "/c.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("x\\x1b[31m\\xc2\\x9b, method handheld"));
  EXPECT_THAT(read_text(folder / "c.json"), HasSubstr("\"odd\xEF\xBF\xBD/session.toml\""));  // U+FFFD
  ASSERT_EQ(run_shell(folder, "cp c.json " + place + "/d.json").exit_code, 0);
  for (const std::string& command :
       {"calibrate " + place + " --method handheld --json", "inspect " + place + "/recording.csv --json",
        "compensate c.json " + place + " -o " + place + "/out.csv --json", "compare c.json " + place + "/d.json --json",
        "export c.json --to csv -o " + place + "/c.csv --json", "simulate " + place + "/session.toml -o " + place + "/new --json"}) {
    const CommandResult printed = run_imulab(folder, command);
    EXPECT_EQ(printed.exit_code, command.starts_with("simulate") ? 2 : 0) << command << printed.errors;  // the session has no steps
    EXPECT_THAT(printed.errors, testing::Not(HasSubstr("json.exception"))) << command;
    EXPECT_EQ((printed.output + printed.errors).find_first_of("\x1b\xff"), std::string::npos) << command;
  }
  EXPECT_EQ(run_imulab(folder, "verify c.json --session-at " + place).exit_code, 0);
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

TEST(BadInput, ACalibrationWithNumbersOfNoSize) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_EQ(run_imulab(folder, "calibrate session --method handheld -o c.json").exit_code, 0);
  std::string huge = read_text(folder / "c.json");
  const std::size_t at = huge.find("\"matrix\"", huge.find("\"gyro\"", huge.find("\"model\"")));  // the first matrix of the gyros: its element xx
  ASSERT_NE(at, std::string::npos);
  huge.replace(huge.find_first_of("-0123456789", at), huge.find(',', at) - huge.find_first_of("-0123456789", at), "1e300");
  folder.write("huge.json", huge);
  for (const char* command :
       {"compensate huge.json session -o out.csv", "compare huge.json c.json", "export huge.json --to csv", "navigate huge.json session"})
    expect_refused(folder, command, "huge.json: gyro.matrix.xx is 1e+300; expected a number from -1e+30 to 1e+30");
}

TEST(BadInput, ACalibrationThatMapsAllToOnePlane) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  folder.write("flat.json", R"({"format": "imulab.calibration/1", "model": {"accel": {"matrix": [[1, 0, 0], [0, 1, 0], [1, 1, 0]]},
      "gyro": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}})");
  for (const char* command : {"compensate flat.json session -o out.csv", "navigate flat.json session"})
    expect_refused(folder, command, "flat.json: accel.matrix is singular; expected three rows");
}

}  // namespace
}  // namespace imulab
