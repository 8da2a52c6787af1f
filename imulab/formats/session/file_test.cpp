#include "imulab/formats/text/file.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/laboratory/file.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/effect_setting.hpp"
#include "tests/session_text.hpp"
#include <cmath>
#include <string>
#include <string_view>

namespace imulab {
namespace {

/// Everything a session can say.
const std::string rich = R"(format = "imulab.session/1"
operator = "A. Person"
station = "table 2"
measured = "2026-03-31T12:00:00Z"
valid_until = "2027-03-31"
warm_up = "45 min at 22 degC"
power_cycles = "none"
[imu]
name = "RLG-90 \"#012\""
firmware = "2.1.4"
filter = "low-pass, 42 Hz"
grade = "navigation"
truth = "truth.json"
accel_noise_density = 5e-5
gyro_noise_density = 2.9e-7
noise = "full"
gyro_noise = { turn_on = { fixed = 1.5e-8 }, quantization = 1e-6, bias_instability = 2e-8, rate_random_walk = 3e-10, rate_ramp = 4e-13, resolution = 5e-6, range = 7.1 }
accel_noise = { }
[site]
latitude_deg = 40.1
longitude_deg = 116.3
height_m = 50
gravity_mps2 = 9.8016
gravity_sigma_mps2 = 1e-5
[[reference]]
quantity = "rotation"
instrument = "table \"A\", number 17"
certificate = "T 2026-12"
date = "2026-03-31"
statement = "U = 2 arcsec, k = 2"
[[reference]]
quantity = "time"
instrument = "counter"
certificate = "C 1"
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
zero_sigma_arcsec = 5.3
mount_sigma_arcsec = { fixed = 10.1 }
rate_sigma_ppm = 11.3
radius_sigma_mm = 0.17
[[rig]]
name = "box"
kind = "chamber"
mount_sigma_arcsec = 61
ramp_K_per_min = 2.1
time_constant_s = 301
hysteresis_K = 0.3
[[recording]]
file = "recording.csv"
rig = "table"
rate_hz = 99.9
time = { column = "t", unit = "us", zero = 1700000000123456.789 }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "deg/h" }
accel = { file = "accel.txt", columns = [2, 3, 4], output = "increment", unit = "count", limits = [-32768, 32767.5] }
extent = "steps"
gyro_temperature = { columns = ["tg"], unit = "raw", noise = 0.0015, at_25_degC = 5000.1, per_K = -0.15 }
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
  const Session s = parse_session(rich);
  EXPECT_EQ(s.imu.name, "RLG-90 \"#012\"");
  EXPECT_EQ(s.imu.gyro_noise_density, 2.9e-7);
  EXPECT_EQ(s.imu.noise, NoiseTerms::full);
  EXPECT_EQ(s.imu.gyro_noise,
            (NoiseModel{.Q = 1e-6, .N = 0, .B = 2e-8, .K = 3e-10, .R = {4e-13, false}, .turn_on = {1.5e-8, true}, .resolution = 5e-6, .range = 7.1}));
  EXPECT_EQ(s.imu.accel_noise, NoiseModel{});
  EXPECT_EQ(s.site.latitude, 40.1 * unit::deg);
  ASSERT_EQ(s.rigs.size(), 3U);
  EXPECT_EQ(s.rigs[0].kind, RigKind::turntable);
  EXPECT_EQ(s.rigs[0].angle, (Spread{60 * unit::arcsec, false}));
  EXPECT_EQ(s.rigs[0].orthogonality, (Spread{-61.7 * unit::arcsec, true}));
  EXPECT_EQ(s.rigs[0].timing, (Spread{10.3e-3, false}));
  EXPECT_EQ((*s.rigs[0].given_orthogonality[static_cast<std::size_t>(RigAxis::outer)])[1], 6.1 * unit::arcsec);
  EXPECT_FALSE(s.rigs[0].given_orthogonality[static_cast<std::size_t>(RigAxis::middle)]);
  EXPECT_EQ(s.rigs[0].given_zero[static_cast<std::size_t>(RigAxis::middle)], 2.3 * unit::arcsec);
  EXPECT_EQ(s.rigs[1].mount, (Spread{10.1 * unit::arcsec, true}));
  EXPECT_EQ(s.rigs[1].rate, (Spread{11.3e-6, false}));
  EXPECT_EQ(s.rigs[1].radius, (Spread{0.17e-3, false}));
  EXPECT_EQ(s.rigs[2].ramp, 2.1 / 60);
  EXPECT_EQ(s.rigs[2].time_constant, 301);
  EXPECT_EQ(s.rigs[2].hysteresis, 0.3);
  ASSERT_EQ(s.recordings.size(), 2U);
  EXPECT_EQ(s.recordings[0].extent, Extent::steps);
  EXPECT_EQ(s.recordings[0].gyro_temperature->noise, 0.0015);
  EXPECT_EQ(s.recordings[0].gyro_temperature->per_K, -0.15);
  EXPECT_EQ(s.recordings[0].time.zero, 1'700'000'000'123'456'789) << "a double would lose the last digits";
  EXPECT_EQ(s.recordings[1].time.zero, 1'700'000'000'123'456'789);
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
  const std::string procedure = session_head +
                                "[rig]\nkind = \"turntable\"\n"
                                "[[step]]\nkind = \"hold\"\nduration_s = 60.7\ninner_deg = 33.3\n"
                                "[[step]]\nkind = \"rotate\"\naxis = \"inner\"\nangle_deg = 0.1\nrate_dps = 7\n"
                                "[[step]]\nkind = \"hold\"\nduration_s = 1\n";
  for (const std::string& text : {rich, procedure, session_head, session_text(dai_unit_procedure({.thermal = ThermalSensors::resonance}))}) {
    Session first = parse_session(text);
    Session second = parse_session(session_text(first));
    EXPECT_EQ(session_text(first), session_text(second));
    second.file = first.file, second.sha256 = first.sha256;  // these name the file itself
    EXPECT_TRUE(first == second) << session_text(first);
  }
}

TEST(SessionFile, AProcedureIsWrittenInDurations) {
  for (const Session& given :
       {zhang_24_procedure({}), six_position_procedure({.rest = 33.3}), cheng_path_procedure({}), hand_held_procedure({}, 1)}) {
    const std::string text = procedure_text(given);
    EXPECT_THAT(text, testing::Not(testing::HasSubstr("start_s")));
    const Session read = parse_session(text);
    ASSERT_EQ(read.steps.size(), given.steps.size());
    for (std::size_t k = 0; k < given.steps.size(); ++k) {
      EXPECT_NEAR(read.steps[k].start, given.steps[k].start, 1e-9);  // sums of decimal durations
      EXPECT_NEAR(read.steps[k].end, given.steps[k].end, 1e-9);
      EXPECT_EQ(read.steps[k].kind, given.steps[k].kind);
      EXPECT_NEAR(read.steps[k].angle, given.steps[k].angle, 1e-12);
    }
  }
  Session odd = six_position_procedure({});
  odd.steps[3].start += 0.5, odd.steps[4].temperature = 30;
  odd.steps.push_back(odd.steps[5]);
  odd.steps[6].start = odd.steps[5].end + 7, odd.steps[6].end = odd.steps[6].start + 1;  // a gap without a move: no duration says that
  const Session read = parse_session(procedure_text(odd));
  for (std::size_t k = 0; k < odd.steps.size(); ++k) {
    EXPECT_NEAR(read.steps[k].start, odd.steps[k].start, 1e-9);
    EXPECT_NEAR(read.steps[k].end, odd.steps[k].end, 1e-9);
  }
}

TEST(SessionFile, FindsTheFolderAndItsFiles) {
  const TemporaryFolder folder;
  folder.write("session.toml", session_head);
  const Session s = read_session(folder.path());
  EXPECT_EQ(s.file, (folder / "session.toml").string());
  EXPECT_EQ(session_path(s, "r.csv"), folder / "r.csv");
  EXPECT_EQ(session_path(s, "/elsewhere/r.csv"), "/elsewhere/r.csv");
}

TEST(SessionFile, LaysAProcedureOutInTime) {
  const Session s = parse_session(session_head +
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
  const std::string other = std::string(session_recording).replace(session_recording.find("r.csv"), 5, "s.csv");
  const Session s = parse_session(session_head + session_recording + other +
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
  const Session s = parse_session(session_head + spin + "rate_dps = 100\n" + spin + "rate_dps = 100\n" + spin + "rate_dps = 0\nmove_s = 20\n");
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

RC_GTEST_PROP(SessionFile, ReadsOrRefusesADamagedFile, ()) {
  std::string text = rich;
  const auto damages = *rc::gen::inRange(1, 4);
  for (int i = 0; i < damages; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text.replace(at, *rc::gen::inRange<std::size_t>(0, 3), 1, *rc::gen::element('\n', ',', '.', '-', 'e', '9', ' ', '[', ']', '{', '=', '"', '\xff'));
  }
  try {
    session_text(parse_session(text));
  } catch (const Error& e) {
    RC_ASSERT(std::string(e.what()).find("session.toml:") != std::string::npos);
  }
}

TEST(SessionFile, ReadsTheExamplesOfItsDocumentation) {
  std::string pages;
  for (const char* page : {"session.md", "recordings.md", "calibration-file.md"})
    pages += MappedFile(std::filesystem::path(IMULAB_SOURCE) / "docs/reference" / page).text();
  std::string_view rest = pages;
  int examples = 0;
  for (std::size_t at = rest.find("```toml\n"); at != std::string_view::npos; at = rest.find("```toml\n")) {
    rest.remove_prefix(at + 8);
    const std::string example(rest.substr(0, rest.find("```")));
    if (example.starts_with("format = \"imulab.laboratory/1\""))
      EXPECT_NO_THROW(parse_laboratory(example, "laboratory.toml")) << example;
    else
      EXPECT_NO_THROW(parse_session(example)) << example;
    ++examples;
  }
  EXPECT_GE(examples, 10);
}

TEST(SessionFile, EveryEffectMayBeDeclaredAbsent) {
  std::string text = "format = \"imulab.session/1\"\n[imu]\nname = \"unit\"\n";
  for (const Effect& effect : effects()) text += std::string(effect.declared()) + " = 0\n";
  const Session session = parse_session(text + "[site]\ngravity_mps2 = 9.8\n", "session.toml");
  for (const Effect& effect : effects()) EXPECT_EQ(session.imu.effect_sigmas.at(std::string(effect.name)), 0) << effect.name;
  EXPECT_EQ(parse_session(session_text(session), "again.toml").imu.effect_sigmas, session.imu.effect_sigmas);
  EXPECT_EQ(kernel::Effects(kernel::effect_sizes(session), everything).size(), 0) << "an absent effect has no column";
}

}  // namespace
}  // namespace imulab
