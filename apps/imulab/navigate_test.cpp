#include "imulab/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/flight_session.hpp"
#include "tests/run_command.hpp"
#include "tests/still_log.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

/// The lines of a file as they stand, the header among them, some changed or left out.
std::string edited(const std::string& text, const std::function<std::optional<std::string>(std::size_t, const std::string&)>& edit) {
  std::istringstream lines(text);
  std::string out;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line); ++number)
    if (const auto kept = edit(number, line)) out += *kept + "\n";
  return out;
}

/// A flight session in `folder`, started as given; `recording` edits its lines.
void write_given(const TemporaryFolder& folder, const std::function<std::optional<std::string>(std::size_t, const std::string&)>& edit = {}) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  write(folder, "session", f);
  if (edit) folder.write("session/recording.csv", edited(read_text(folder / "session/recording.csv"), edit));
}

TEST(NavigateCommand, NavigatesWritesAndHoldsAgainstTheTruth) {
  const TemporaryFolder folder;
  write_given(folder);
  const CommandResult text = run_imulab(folder, "navigate none session -o nav.csv");
  ASSERT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_EQ(text.errors, "");
  EXPECT_THAT(text.output, HasSubstr("navigated from 40.000 s to 100.000 s (60.0 s), vertical channel free"));
  EXPECT_THAT(text.output, HasSubstr("errors at 100.000 s"));
  EXPECT_EQ(read_solution(folder / "nav.csv").size(), 3001u);

  const CommandResult machine = run_imulab(folder, "navigate none session --json --vertical fixed");
  ASSERT_EQ(machine.exit_code, 0) << machine.errors;
  const Json j = Json::parse(machine.output);
  EXPECT_EQ(j["vertical"], "fixed");
  const Json& p = j["position_error"];
  EXPECT_NEAR(p["horizontal_m"].get<double>(), std::hypot(p["east_m"].get<double>(), p["north_m"].get<double>()), 1e-12);
  EXPECT_LT(p["horizontal_m"].get<double>(), 2e-3);  // an ideal unit: the integrator's own
  EXPECT_NEAR(p["rate_nmi_per_h"].get<double>(), p["horizontal_m"].get<double>() / 1852 / (60. / 3600), 1e-12);
  EXPECT_EQ(j["velocity_error_mps"].size(), 3u);
  EXPECT_EQ(j["attitude_error_arcsec"].size(), 3u);
}

TEST(NavigateCommand, WritesTheSameToAFileAndToAStreamAndNothingWhereItFails) {
  const TemporaryFolder folder;
  write_still_log(folder, 12000, still_readings);  // a solution of 1.3 MB: more than is written at once
  const std::string session = read_text(folder / "session.toml");
  const auto start_at = [&](const char* place) {
    folder.write("session.toml", session + "[initial]\nlongitude_deg = 8\nheight_m = 400\nroll_deg = 0\npitch_deg = 0\nheading_deg = 0\n" + place);
  };
  start_at("latitude_deg = 47\nvelocity_enu_mps = [0, 0, 0]\n");
  const CommandResult file = run_imulab(folder, "navigate none session.toml --vertical fixed -o solution.csv");
  ASSERT_EQ(file.exit_code, 0) << file.errors;
  EXPECT_THAT(file.output, HasSubstr("solution.csv: 12001 states"));
  EXPECT_EQ(run_imulab(folder, "navigate none session.toml --vertical fixed -o -").output, read_text(folder / "solution.csv"));
  start_at("latitude_deg = 87\nvelocity_enu_mps = [0, 3000, 0]\n");  // near the pole after 107 s
  for (const char* output : {"-", "none.csv"}) {
    const CommandResult failed = run_imulab(folder, std::string("navigate none session.toml --vertical fixed -o ") + output);
    EXPECT_EQ(failed.exit_code, 2);
    EXPECT_EQ(failed.output, "");
    EXPECT_THAT(failed.errors, HasSubstr("from the equator"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "none.csv"));
}

TEST(NavigateCommand, AlignsOnTheRest) {
  const TemporaryFolder folder;
  FlightSession f = flight_session(1);
  f.session.initial = flight_start();
  f.session.initial->heading = 0;  // wrong: --align does not use it
  write(folder, "session", f);
  const CommandResult text = run_imulab(folder, "navigate none session --align");
  ASSERT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_THAT(text.output, HasSubstr("aligned on the rest from 0.500 s to "));
  EXPECT_THAT(text.output, HasSubstr("heading"));
  const Json j = Json::parse(run_imulab(folder, "navigate none session --heading 30 --heading-sigma 0.5 --json").output);
  EXPECT_NEAR(j["alignment"]["roll_pitch_heading_deg"][2].get<double>(), 30, 0.5);
  EXPECT_LT(j["alignment"]["standard_uncertainty_deg"][2].get<double>(), 0.5);  // the Earth's rate says more
}

TEST(NavigateCommand, WarnsOfAForceThatIsNotG) {
  const TemporaryFolder folder;
  FlightSession f = flight_session(1, 1);
  f.session.initial = flight_start();
  write(folder, "session", f);
  Calibration other;
  other.model.gyro.raw_unit = "rad/s";
  other.model.accel.raw_unit = "m/s^2";
  other.model.accel.matrix *= 100;
  other.covariance.resize(0, 0);
  folder.write("other.json", calibration_text(other));
  EXPECT_THAT(run_imulab(folder, "navigate other.json session").errors, HasSubstr("m/s^2 (median), expected about g"));
  EXPECT_THAT(run_imulab(folder, "navigate none session").errors, testing::Not(HasSubstr("expected about g")));
}

TEST(NavigateCommand, SeveralSessionsGiveARateOfTheSet) {
  const TemporaryFolder folder;
  std::vector<double> rates;
  std::string names;
  for (int k = 1; k <= 3; ++k) {
    write(folder, "s" + std::to_string(k), flight_session(1, static_cast<std::uint64_t>(k)));
    names += " s" + std::to_string(k);
    rates.push_back(Json::parse(run_imulab(folder, "navigate none s" + std::to_string(k) + " --json").output)["position_error"]["rate_nmi_per_h"]);
  }
  const CommandResult machine = run_imulab(folder, "navigate none" + names + " --json");
  ASSERT_EQ(machine.exit_code, 0) << machine.errors;
  const Json j = Json::parse(machine.output);
  ASSERT_EQ(j["sessions"].size(), 3u);
  std::sort(rates.begin(), rates.end());
  EXPECT_DOUBLE_EQ(j["rate_nmi_per_h"]["cep"].get<double>(), rates[1]);
  EXPECT_NEAR(j["rate_nmi_per_h"]["rms"].get<double>(), std::sqrt((rates[0] * rates[0] + rates[1] * rates[1] + rates[2] * rates[2]) / 3), 1e-9);
  EXPECT_THAT(run_imulab(folder, "navigate none" + names).output, HasSubstr("pure-inertial rate over 3 sessions: RMS "));
  EXPECT_THAT(run_imulab(folder, "navigate none -o nav.csv" + names).errors, HasSubstr("--output: belongs to one session"));
}

TEST(NavigateCommand, TheVerticalChannelNeedsItsBarometer) {
  const TemporaryFolder folder;
  write_given(folder);
  const CommandResult without = run_imulab(folder, "navigate none session --vertical aided");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.errors, HasSubstr("vertical channel aided: no barometer's heights"));
  folder.write("baro.csv", "t,height_m\n0,100\n100,100\n");
  for (const std::string vertical : {"aided", "held"}) {
    const CommandResult with = run_imulab(folder, "navigate none session --barometer baro.csv --json --vertical " + vertical);
    ASSERT_EQ(with.exit_code, 0) << with.errors;
    EXPECT_NEAR(Json::parse(with.output)["position_error"]["up_m"].get<double>(), 0, 2e-3);  // the flight is level
  }
  folder.write("short.csv", "t,height_m\n0,100\n50,100\n");
  EXPECT_THAT(run_imulab(folder, "navigate none session --vertical held --barometer short.csv").errors,
              HasSubstr("expected all of 40.000 s to 100.000 s"));
  EXPECT_THAT(run_imulab(folder, "navigate none session --barometer baro.csv").errors, HasSubstr("belongs to --vertical aided or held"));
}

TEST(NavigateCommand, GapsAreIntegratedAndSaidOrRefused) {
  const TemporaryFolder folder;
  write_given(folder, [](std::size_t line, const std::string& text) { return line > 3000 && line <= 3010 ? std::nullopt : std::optional(text); });
  const CommandResult result = run_imulab(folder, "navigate none session --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("1 gap of 0.2 s altogether, the first after 60.000000 s: integrated with rate and force linear in time"));
  EXPECT_THAT(result.errors, Not(HasSubstr("no rotation is integrated")));
  const Json gaps = Json::parse(result.output)["gaps"];
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_NEAR(gaps[0]["begin_s"].get<double>(), 60, 1e-9);
  EXPECT_NEAR(gaps[0]["length_s"].get<double>(), 0.2, 1e-9);
  const CommandResult refused = run_imulab(folder, "navigate none session --gaps refuse -o nav.csv");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("0.200000 s are missing after 60.000000 s, and gaps are to be refused"));
  EXPECT_FALSE(std::filesystem::exists(folder / "nav.csv"));
}

TEST(NavigateCommand, JitterAndSaturationAreSaid) {
  const TemporaryFolder folder;
  write_given(folder, [](std::size_t line, const std::string& text) -> std::optional<std::string> {
    if (line == 0) return text;
    const std::size_t comma = text.find(',');
    const double t = 0.02 * static_cast<double>(line) + (line % 2 == 0 ? 0.003 : 0);  // 13, 7, 13 ms late of 20
    std::string out = fmt::format("{:.9f}{}", t, text.substr(comma));
    if (line == 3000) out = fmt::format("{:.9f},0.5,0,0,0,0,9.8", t);
    return out;
  });
  const CommandResult result = run_imulab(folder, "navigate none session --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("the stamps' differences scatter by 1"));
  EXPECT_THAT(result.errors, HasSubstr("1 saturated sample integrated as read, the first at 60.003000 s"));
  EXPECT_EQ(Json::parse(result.output)["saturated"], 1);
}

TEST(NavigateCommand, AlignmentNeedsARestAndALongOne) {
  const TemporaryFolder folder;
  FlightSession f = flight_session(1);
  for (std::size_t k = 0; k < 3; ++k) {  // it rests for 5 s only
    f.recording.gyro[k].erase(f.recording.gyro[k].begin(), f.recording.gyro[k].begin() + 1750);
    f.recording.accel[k].erase(f.recording.accel[k].begin(), f.recording.accel[k].begin() + 1750);
  }
  f.recording.time_ns.erase(f.recording.time_ns.begin(), f.recording.time_ns.begin() + 1750);
  Step hold;
  hold.recording = "recording.csv";
  hold.start = 35;
  hold.end = 40;
  f.session.steps = {hold};
  write(folder, "short", f);
  const CommandResult brief = run_imulab(folder, "navigate none short");
  EXPECT_EQ(brief.exit_code, 1);
  EXPECT_THAT(brief.errors, HasSubstr("the rest has 240 samples over 4.800 s, at least 20 over 10 s are needed"));
  f.session.steps[0].start = 200;
  f.session.steps[0].end = 260;
  write(folder, "none", f);
  const CommandResult none = run_imulab(folder, "navigate none none");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("recording.csv: no rest was found to align on; give an initial state"));
}

TEST(NavigateCommand, WhatIsWrongIsNamed) {
  const TemporaryFolder folder;
  write_given(folder);
  const std::string session = read_text(folder / "session/session.toml");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string out = session;
    const std::size_t at = out.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) out.replace(at, from.size(), to);
    return out;
  };
  Calibration counts;
  counts.model.gyro.raw_unit = counts.model.accel.raw_unit = "count";
  folder.write("counts.json", calibration_text(counts));
  std::string pole = session;
  for (std::size_t at = 0; (at = pole.find("latitude_deg = 45", at)) != std::string::npos;) pole.replace(at, 17, "latitude_deg = 90");
  folder.write("session/pole.toml", pole);
  folder.write("session/late.toml", changed("time_s = 40", "time_s = 4000"));
  folder.write("session/count.toml", changed("unit = \"rad/s\"", "unit = \"count\""));
  folder.write("session/lost.toml", changed("truth.csv", "lost.csv"));
  folder.write("elsewhen.csv",
               "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n500,45,0,0,0,0,0,0,0,0\n510,45,0,0,0,0,0,0,0,0\n");
  folder.write("session/huge.csv", edited(read_text(folder / "session/recording.csv"), [](std::size_t line, const std::string& text) {
                 return std::optional(line == 4500 ? text.substr(0, text.rfind(',')) + ",1e300" : text);
               }));
  folder.write("session/huge.toml", changed("file = \"recording.csv\"", "file = \"huge.csv\""));
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c :
       {Case{"counts.json session", "accel is in m/s^2, expected count, which the calibration was made from"},
        Case{"none session/count.toml", "gyro is in count, expected rad/s"},
        Case{"none session/huge.toml", "accel z is 1e+300 m/s^2; expected a reading that a sensor can give"},
        Case{"none session/pole.toml", "latitude 90.000000 deg"}, Case{"none session/pole.toml --align", "latitude 90.000000 deg"},
        Case{"none session/late.toml", "navigation starts at 4000.000000 s, expected inside the recording, 0.000000 s to 100.000000 s"},
        Case{"none session --truth elsewhen.csv",
             "elsewhen.csv: the truth runs from 500.000 s to 510.000 s, the solution from 40.000 s to 100.000 s: expected times that overlap"},
        Case{"none session/lost.toml", "lost.csv: cannot be opened"}, Case{"none session -o session/recording.csv", "would overwrite"},
        Case{"none session -o session", "expected a file to write"}, Case{"none session --heading nan", "--heading: nan; expected a finite number"},
        Case{"none session --heading 3 --heading-sigma nan", "--heading-sigma: nan; expected a finite number"},
        Case{"none session --heading-sigma 1", "--heading-sigma: belongs to --heading"}, Case{"none session --heading 400", "--heading"},
        Case{"none session --vertical up", "--vertical"}, Case{"nothing.json session", "nothing.json"}, Case{"none", "SESSION"}}) {
    const CommandResult result = run_imulab(folder, std::string("navigate ") + c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments << "\n" << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(c.message)) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
  }
  folder.write("empty.csv", "t,latitude_deg\n");
  const std::string errors = run_imulab(folder, "navigate none session --truth empty.csv").errors;
  EXPECT_THAT(errors, testing::HasSubstr("empty.csv"));
  EXPECT_EQ(errors.find("empty.csv"), errors.rfind("empty.csv")) << errors;  // named once
}

}  // namespace
}  // namespace imulab
