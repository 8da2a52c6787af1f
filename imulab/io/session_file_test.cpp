#include "imulab/io/session_file.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/recording/turn.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/temporary_folder.hpp"
#include <cmath>
#include <string>
#include <string_view>

namespace imulab {
namespace {

using testing::HasSubstr;

const std::string head = "format = \"imulab.session/1\"\n";
const std::string recording =
    "[[recording]]\n"
    "file = \"r.csv\"\n"
    "time = { column = \"t\", unit = \"s\" }\n"
    "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"count\" }\n"
    "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"count\" }\n";

Session parse(const std::string& text) {
  const TemporaryFolder folder;
  return read_session(folder.write("session.toml", text));
}

/// Everything a session can say.
const std::string rich = R"(format = "imulab.session/1"
[imu]
name = "RLG-90 \"#012\""
grade = "navigation"
truth = "truth.json"
accel_noise_density = 5e-5
gyro_noise_density = 2.9e-7
[site]
latitude_deg = 40.1
longitude_deg = 116.3
height_m = 50
gravity_mps2 = 9.8016
gravity_sigma_mps2 = 1e-5
[[rig]]
name = "table"
kind = "turntable"
angle_sigma_arcsec = 60.0
orthogonality_sigma_arcsec = { fixed = -61.7 }
zero_sigma_arcsec = 13
timing_sigma_ms = 10.3
orthogonality_arcsec = { inner = [1, 2], outer = [5, 6.1] }
zero_arcsec = { outer = 1, middle = 2.3 }
[[rig]]
name = "arm"
kind = "centrifuge"
[[recording]]
file = "recording.csv"
rig = "table"
rate_hz = 99.9
time = { column = "t", unit = "us", zero = 1700000000123456.789 }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "deg/h" }
accel = { file = "accel.txt", columns = [2, 3, 4], output = "increment", unit = "count", limits = [-32768, 32767.5] }
gyro_temperature = { columns = ["tg"], unit = "raw" }
accel_temperature = { columns = ["t1", "t2", 9], unit = "K" }
[[recording]]
file = "arm.csv"
rig = "arm"
time = { column = 1, unit = "ns", zero = 1700000000123456789 }
gyro = { columns = [2, 3, 4], output = "increment", unit = "deg" }
accel = { columns = [5, 6, 7], output = "rate", unit = "g" }
[[step]]
recording = "recording.csv"
kind = "hold"
start_s = -3.5
end_s = 180.1
outer_deg = 0.1
middle_deg = 7.3
temperature_degC = 25.0
[[step]]
recording = "recording.csv"
kind = "rotate"
start_s = 180.1
end_s = 189
axis = "middle"
angle_deg = -90.1
rate_dps = 10.3
acceleration_dps2 = 51
[[step]]
recording = "arm.csv"
kind = "spin"
start_s = 0
end_s = 30
up = "+z"
outward = "-x"
rate_dps = -220.1
radius_m = [6.1, 6.102, 6.098]
[initial]
time_s = 0.5
latitude_deg = 30.95
longitude_deg = 104.33
height_m = 3000
velocity_enu_mps = [200, -0.1, 0]
roll_deg = 0.3
pitch_deg = 1.7
heading_deg = 90
[truth]
file = "truth.csv"
)";

TEST(SessionFile, ReadsWhatItSaysInSi) {
  const Session s = parse(rich);
  EXPECT_EQ(s.imu.name, "RLG-90 \"#012\"");
  EXPECT_EQ(s.imu.gyro_noise_density, 2.9e-7);
  EXPECT_EQ(s.site.latitude, 40.1 * unit::deg);
  ASSERT_EQ(s.rigs.size(), 2U);
  EXPECT_EQ(s.rigs[0].kind, RigKind::turntable);
  EXPECT_EQ(s.rigs[0].angle, (Spread{60 * unit::arcsec, false}));
  EXPECT_EQ(s.rigs[0].orthogonality, (Spread{-61.7 * unit::arcsec, true}));
  EXPECT_EQ(s.rigs[0].timing, (Spread{10.3e-3, false}));
  EXPECT_EQ((*s.rigs[0].given_orthogonality[static_cast<std::size_t>(RigAxis::outer)])[1], 6.1 * unit::arcsec);
  EXPECT_FALSE(s.rigs[0].given_orthogonality[static_cast<std::size_t>(RigAxis::middle)]);
  EXPECT_EQ(s.rigs[0].given_zero[static_cast<std::size_t>(RigAxis::middle)], 2.3 * unit::arcsec);
  ASSERT_EQ(s.recordings.size(), 2U);
  EXPECT_EQ(s.recordings[0].time.zero_ns, 1'700'000'000'123'456'789) << "a double would lose the last digits";
  EXPECT_EQ(s.recordings[1].time.zero_ns, 1'700'000'000'123'456'789);
  EXPECT_EQ(s.recordings[0].accel.file, "accel.txt");
  EXPECT_EQ(s.recordings[0].accel.output, Output::increment);
  EXPECT_EQ((*s.recordings[0].accel.limits)[1], 32767.5);
  EXPECT_EQ(s.recordings[0].accel_temperature->columns[2], Column(9));
  ASSERT_EQ(s.steps.size(), 3U);
  EXPECT_EQ(s.steps[1].angle, -90.1 * unit::deg);
  EXPECT_EQ(s.steps[1].acceleration, 51 * unit::deg);
  EXPECT_EQ(s.steps[2].rate, -220.1 * unit::deg);
  EXPECT_EQ(s.steps[2].mount, (Mount{{2, 1}, {0, -1}}));
  EXPECT_EQ(s.steps[2].radius, (std::array{6.1, 6.102, 6.098}));
  EXPECT_EQ(s.initial->heading, 90 * unit::deg);
  EXPECT_EQ(s.initial->velocity_enu[0], 200);
  EXPECT_EQ(s.truth_file, "truth.csv");
  EXPECT_EQ(s.sha256, sha256(rich));
}

TEST(SessionFile, WritesWhatItReadsBackIdentically) {
  const std::string procedure = head +
                                "[rig]\nkind = \"turntable\"\n"
                                "[[step]]\nkind = \"hold\"\nduration_s = 60.7\ninner_deg = 33.3\n"
                                "[[step]]\nkind = \"rotate\"\naxis = \"inner\"\nangle_deg = 0.1\nrate_dps = 7\n"
                                "[[step]]\nkind = \"hold\"\nduration_s = 1\n";
  for (const std::string& text : {rich, procedure, head}) {
    Session first = parse(text);
    Session second = parse(session_text(first));
    EXPECT_EQ(session_text(first), session_text(second));
    second.file = first.file, second.sha256 = first.sha256;  // these name the file itself
    EXPECT_TRUE(first == second) << session_text(first);
  }
}

TEST(SessionFile, FindsTheFolderAndItsFiles) {
  const TemporaryFolder folder;
  folder.write("session.toml", head);
  const Session s = read_session(folder.path());
  EXPECT_EQ(s.file, (folder / "session.toml").string());
  EXPECT_EQ(session_path(s, "r.csv"), folder / "r.csv");
  EXPECT_EQ(session_path(s, "/elsewhere/r.csv"), "/elsewhere/r.csv");
}

TEST(SessionFile, LaysAProcedureOutInTime) {
  const Session s = parse(head +
                          "[[step]]\nkind = \"hold\"\nduration_s = 100\n"                                    // at zero: no move
                          "[[step]]\nkind = \"rotate\"\naxis = \"middle\"\nangle_deg = 90\nrate_dps = 10\n"  // 90/10 + 10/50
                          "[[step]]\nkind = \"hold\"\nduration_s = 60\n"                                     // stays at 90
                          "[[step]]\nkind = \"rotate\"\naxis = \"middle\"\nangle_deg = -1\nrate_dps = 10\n"  // never reaches 10 deg/s
                          "[[step]]\nkind = \"hold\"\nduration_s = 60\nouter_deg = 30\n"                     // outer moves in 10 s
                          "[[step]]\nkind = \"hold\"\nduration_s = 60\nmiddle_deg = 0\nmove_s = 25\n"        // middle moves in 25 s
                          "[[step]]\nkind = \"hold\"\nduration_s = 60\nmiddle_deg = 0\nmove_s = 25\n");      // no move: there already
  ASSERT_EQ(s.steps.size(), 7U);
  const double turn = 9.2, short_turn = 2 * std::sqrt(1.0 / 50);
  const double starts[] = {0, 100, 100 + turn, 160 + turn, 170 + turn + short_turn, 255 + turn + short_turn, 315 + turn + short_turn};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(s.steps[i].start, starts[i], 1e-12) << i;  // rounding of sums of a few hundred seconds
  EXPECT_NEAR(s.steps[6].end, 375 + turn + short_turn, 1e-12);
  EXPECT_EQ(s.steps[1].acceleration, 50 * unit::deg);
  EXPECT_EQ(s.steps[2].angles, (std::array{0.0, 90 * unit::deg, 0.0}));
  EXPECT_EQ(s.steps[4].angles, (std::array{30 * unit::deg, 89 * unit::deg, 0.0}));
}

TEST(SessionFile, BeginsEachRecordingAnew) {
  const std::string other = std::string(recording).replace(recording.find("r.csv"), 5, "s.csv");
  const Session s = parse(head + recording + other +
                          "[[step]]\nrecording = \"r.csv\"\nkind = \"hold\"\nduration_s = 10\ninner_deg = 90\n"  // reached by a move
                          "[[step]]\nrecording = \"s.csv\"\nkind = \"hold\"\nduration_s = 10\n"
                          "[[step]]\nrecording = \"r.csv\"\nkind = \"hold\"\nduration_s = 10\n");
  EXPECT_EQ(s.steps[0].start, 10);
  EXPECT_EQ(s.steps[1].start, 0);
  EXPECT_EQ(s.steps[1].angles[static_cast<std::size_t>(RigAxis::inner)], 0);
  EXPECT_EQ(s.steps[2].start, 20);
  EXPECT_EQ(s.steps[2].angles[static_cast<std::size_t>(RigAxis::inner)], 90 * unit::deg);
}

TEST(SessionFile, GivesEachSpinTimeToReachItsRate) {
  const std::string spin = "[[step]]\nkind = \"spin\"\nduration_s = 30\nup = \"+z\"\noutward = \"+x\"\nradius_m = 6\n";
  const Session s = parse(head + spin + "rate_dps = 100\n" + spin + "rate_dps = 100\n" + spin + "rate_dps = 0\nmove_s = 20\n");
  EXPECT_EQ(s.steps[0].start, 10);
  EXPECT_EQ(s.steps[1].start, 40);
  EXPECT_EQ(s.steps[2].start, 90);
  EXPECT_EQ(s.steps[0].radius, (std::array{6.0, 6.0, 6.0}));
}

TEST(SessionFile, TurnsInTheTimeOfTheirTrapezoid) {
  EXPECT_DOUBLE_EQ(turn_duration(-90, 10, 50), 9.2);
  EXPECT_DOUBLE_EQ(turn_duration(2, 10, 50), 0.4);  // just reaches its rate: both forms agree
  EXPECT_DOUBLE_EQ(turn_duration(1, 10, 50), 2 * std::sqrt(1.0 / 50));
}

TEST(SessionFile, NamesFileLineFieldAndWhatWasExpected) {
  const auto hold = [](const std::string& keys) { return head + "[[step]]\nkind = \"hold\"\n" + keys; };
  const auto changed = [](const std::string& from, const std::string& to) {
    return head + std::string(recording).replace(recording.find(from), from.size(), to);
  };
  const struct {
    std::string text, message;
  } cases[] = {
      {"", ":1: format: is missing"},
      {"format = \"imulab.session/2\"\n[imu]\nfuture = 1\n",
       ":1: format: \"imulab.session/2\" is a format this version does not know, expected \"imulab.session/1\""},
      {"format = \"toast\"\n", ":1: format: \"toast\" is not a session"},
      {"format = 3\n", ":1: format: is a number, expected text in quotes"},
      {head + "[imu\n", ":2: "},
      {head + "[imu]\nnamme = \"x\"\n", ":3: imu.namme: is not a known key, expected name"},
      {head + "[imu]\nzzzzzzzz = \"x\"\n", ":3: imu.zzzzzzzz: is not a known key, expected one of name, grade, truth"},
      {head + "[imu]\ngrade = \"navigation\"\n", ":2: imu.name: is missing"},
      {head + "[imu]\nname = \"x\"\ngyro_noise_density = -1\n", ":4: imu.gyro_noise_density: -1 is out of range, expected at least 0"},
      {head + "sites = 1\n", ":2: sites: is not a known key, expected site"},
      {head + "site = 1\n", ":2: site: is a number, expected a table"},
      {head + "[site]\nlatitude_deg = 91\n", ":3: site.latitude_deg: 91 is out of range, expected -90 to 90"},
      {head + "[site]\nlatitude_deg = \"N\"\n", ":3: site.latitude_deg: is text, expected a number"},
      {head + "[site]\nheight_m = nan\n", ":3: site.height_m: is not a finite number"},
      {head + "[site]\ngravity_mps2 = 980.1\n", ":3: site.gravity_mps2: 980.1 is out of range, expected 9 to 10.5"},
      {head + "[rig]\nkind = \"swing\"\n",
       ":3: rig.kind: \"swing\" is not allowed, expected one of turntable, rate_table, centrifuge, chamber, none"},
      {head + "[rig]\nkind = \"none\"\nangle_sigma_arcsec = -3\n", ":4: rig.angle_sigma_arcsec: -3 is out of range, expected at least 0"},
      {head + "[rig]\nkind = \"none\"\nangle_sigma_arcsec = { fix = 3 }\n", ":4: rig.angle_sigma_arcsec.fix: is not a known key, expected fixed"},
      {head + "[rig]\nkind = \"none\"\northogonality_arcsec = { inner = [1] }\n", ":4: rig.orthogonality_arcsec.inner: 1 numbers, expected 2"},
      {head + "[[rig]]\nkind = \"none\"\n[[rig]]\nkind = \"none\"\n", ":4: rig.name: is missing, expected since there are several rigs"},
      {changed("file = \"r.csv\"\n", ""), ":2: recording.file: is missing"},
      {changed("file = \"r.csv\"\n", "file = \"r.csv\"\nrate_hz = 0\n"), ":4: recording.rate_hz: 0 is out of range, expected more than 0"},
      {changed("file = \"r.csv\"\n", "file = \"r.csv\"\nrig = \"q\"\n"), ":4: recording.rig: \"q\" is no rig of this session"},
      {changed("unit = \"s\"", "unit = \"min\""), ":4: recording.time.unit: \"min\" is not allowed, expected one of s, ms, us, ns"},
      {changed("unit = \"s\"", "unit = \"s\", zero = 1e300"), ":4: recording.time.zero: is more than 292 years"},
      {changed("column = \"t\"", "column = 0"), ":4: recording.time.column: column 0 is out of range, expected 1 or more"},
      {changed("column = \"t\"", "column = 1.5"), ":4: recording.time.column: is a number, expected a column's name or its number"},
      {changed("\"gx\", ", ""), ":5: recording.gyro.columns: 2 columns, expected 3"},
      {changed("\"gx\", ", "\"gz\", "), ":5: recording.gyro.columns: the same column twice"},
      {changed("unit = \"count\" }\naccel", "unit = \"furlong\" }\naccel"),
       ":5: recording.gyro.unit: \"furlong\" is not allowed, expected one of count, rad/s, deg/s, deg/h"},
      {changed("unit = \"count\" }\naccel", "unit = \"deg\" }\naccel"),
       ":5: recording.gyro.unit: \"deg\" is not allowed, expected one of count, rad/s, deg/s, deg/h"},
      {changed("output = \"rate\", unit = \"count\" }\naccel", "output = \"increment\", unit = \"deg/s\" }\naccel"),
       ":5: recording.gyro.unit: \"deg/s\" is not allowed, expected one of count, rad, deg"},
      {changed("unit = \"count\" }\naccel", "unit = \"count\", limits = [5, 5] }\naccel"), ":5: recording.gyro.limits: are not in order"},
      {changed("accel = {", "gyro_temperature = { columns = [1, 2], unit = \"degC\" }\naccel = {"),
       ":6: recording.gyro_temperature.columns: 2 columns, expected 1 or 3"},
      {changed("accel = {", "gyro_temperature = { columns = [1], unit = \"degF\" }\naccel = {"),
       ":6: recording.gyro_temperature.unit: \"degF\" is not allowed, expected one of degC, K, raw"},
      {head + recording + recording, ":8: recording.file: is the file of a recording before"},
      {hold(""), ":2: step.duration_s: is missing, expected duration_s (a procedure) or start_s and end_s"},
      {hold("start_s = 1\n"), ":4: step.start_s: stands alone"},
      {hold("start_s = 1\nend_s = 1\n"), ":5: step.end_s: 1 is not after start_s"},
      {hold("start_s = 1\nend_s = 2\nduration_s = 1\n"), ":6: step.duration_s: beside start_s and end_s"},
      {hold("duration_s = 0\n"), ":4: step.duration_s: 0 is out of range, expected more than 0"},
      {hold("duration_s = 1\nangle_deg = 5\n"), ":5: step.angle_deg: is not a known key"},
      {hold("duration_s = 1\nup = \"+z\"\n"), ":5: step.up: stands alone, expected both up and outward"},
      {hold("duration_s = 1\nup = \"+z\"\noutward = \"-z\"\n"), ":6: step.outward: is along up"},
      {hold("duration_s = 1\nup = \"z\"\noutward = \"-z\"\n"), ":5: step.up: \"z\" is not allowed, expected one of +x, +y, +z, -x, -y, -z"},
      {hold("start_s = 0\nend_s = 2\n[[step]]\nkind = \"hold\"\nstart_s = 1.5\nend_s = 3\n"),
       ":8: step.start_s: 1.5 is before the end of the step before, expected at least 2"},
      {head + "[[step]]\nkind = \"rotate\"\naxis = \"outer\"\nangle_deg = 90\nrate_dps = -10\n",
       ":6: step.rate_dps: -10 is out of range, expected more than 0"},
      {head + "[[step]]\nkind = \"rotate\"\naxis = \"outer\"\nangle_deg = 0\nrate_dps = 10\n", ":5: step.angle_deg: is 0"},
      {head + "[[step]]\nkind = \"rotate\"\naxis = \"up\"\nangle_deg = 9\nrate_dps = 10\n",
       ":4: step.axis: \"up\" is not allowed, expected one of outer, middle, inner"},
      {head + "[[step]]\nkind = \"spin\"\nduration_s = 3\nrate_dps = 10\nradius_m = [1, 2]\n", ":6: step.radius_m: 2 numbers, expected 3"},
      {head + recording + "[[step]]\nkind = \"hold\"\nduration_s = 1\nrecording = \"x.csv\"\n",
       ":10: step.recording: \"x.csv\" is no recording of this session, expected r.csv"},
      {head + "[initial]\nlatitude_deg = 1\nlongitude_deg = 2\nheight_m = 3\nvelocity_enu_mps = [1, 2]\n",
       ":6: initial.velocity_enu_mps: 2 numbers, expected 3"},
      {head + "[truth]\n", ":2: truth.file: is missing"},
  };
  for (const auto& c : cases) {
    try {
      parse(c.text);
      ADD_FAILURE() << "accepted:\n" << c.text;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("session.toml" + c.message)) << c.text;
    }
  }
}

RC_GTEST_PROP(SessionFile, ReadsOrRefusesADamagedFile, ()) {
  std::string text = rich;
  const auto damages = *rc::gen::inRange(1, 4);
  for (int i = 0; i < damages; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text.replace(at, *rc::gen::inRange<std::size_t>(0, 3), 1, *rc::gen::element('\n', ',', '.', '-', 'e', '9', ' ', '[', ']', '{', '=', '"', '\xff'));
  }
  try {
    session_text(parse(text));
  } catch (const Error& e) {
    RC_ASSERT(std::string(e.what()).find("session.toml:") != std::string::npos);
  }
}

TEST(SessionFile, ReadsTheExamplesOfItsDocumentation) {
  const MappedFile page(std::filesystem::path(IMULAB_SOURCE) / "docs/formats.md");
  std::string_view rest = page.text();
  int examples = 0;
  for (std::size_t at = rest.find("```toml\n"); at != std::string_view::npos; at = rest.find("```toml\n")) {
    rest.remove_prefix(at + 8);
    EXPECT_NO_THROW(parse(std::string(rest.substr(0, rest.find("```"))))) << rest.substr(0, rest.find("```"));
    ++examples;
  }
  EXPECT_GE(examples, 2);
}

TEST(SessionFile, NamesAMissingFile) {
  EXPECT_THAT([] { read_session("/nowhere/session.toml"); }, testing::ThrowsMessage<Error>(HasSubstr("/nowhere/session.toml: cannot be opened")));
}

}  // namespace
}  // namespace imulab
