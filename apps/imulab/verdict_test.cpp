// The verdict about what was required: the same in the terminal, the exit code, the JSON and the page, also of a saved result.
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/recorded_session.hpp"
#include "tests/still_log.hpp"
#include <algorithm>
#include <regex>

namespace imulab {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* drift_mission = R"(format = "imulab.mission/1"
rate_hz = 10
[start]
latitude_deg = 45
longitude_deg = 8
height_m = 400
speed_mps = 100
[[segment]]
kind = "straight"
duration_s = 300
[errors]
grade = "navigation"
vertical = "fixed"
)";

std::vector<std::string> first_keys(const OrderedJson& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items())
    if (keys.size() < 3) keys.push_back(key);
  return keys;
}

/// The verdict of a command line everywhere, and of `imulab report` on its JSON where it takes that.
void expect_verdict(const TemporaryFolder& folder, const std::string& command, const std::string& verdict, int exit_code, bool has_page = true,
                    bool is_saved = true) {
  const CommandResult text = run_imulab(folder, command + (has_page ? " --report page.html" : ""));
  EXPECT_EQ(text.exit_code, exit_code) << command << text.errors;
  EXPECT_THAT(text.output, StartsWith(verdict + ": ")) << command;
  const CommandResult json = run_imulab(folder, command + " --json");
  EXPECT_EQ(json.exit_code, exit_code) << command << json.errors;
  const OrderedJson data = OrderedJson::parse(json.output);
  EXPECT_THAT(first_keys(data), testing::ElementsAre("verdict", "headline", "warnings")) << command;
  EXPECT_EQ(data["verdict"], verdict) << command;
  EXPECT_THAT(on_one_line(text.output), StartsWith(verdict + ": " + data["headline"].get<std::string>()));
  std::vector<std::string> pages;
  if (has_page) pages.push_back(read_text(folder / "page.html"));
  if (is_saved) {
    folder.write("saved.json", json.output);
    EXPECT_EQ(run_imulab(folder, "report saved.json -o saved.html").exit_code, 0) << command;
    pages.push_back(read_text(folder / "saved.html"));
  }
  const bool green = verdict == "met" || verdict == "good";
  for (const std::string& page : pages) {
    EXPECT_THAT(page, HasSubstr("<strong id=\"verdict\">" + verdict + "</strong>")) << command;
    EXPECT_THAT(page, HasSubstr(green ? "<div class=\"verdict good\">" : "<div class=\"verdict doubtful\">")) << command;
  }
}

TEST(Verdict, OfACalibrationIsAboutItsRequirements) {  // ctest: once
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  const std::string calibrate = "calibrate session --method handheld --force -o c.json ";
  const CommandResult missed = run_imulab(folder, calibrate + "--report c.html --require 'gyro.matrix.diagonal <= 1 ppm, accel.offset <= 100 mg'");
  EXPECT_EQ(missed.exit_code, 1);
  EXPECT_THAT(missed.output, StartsWith("not met: gyro.matrix."));
  EXPECT_THAT(read_text(folder / "c.html"), HasSubstr("<div class=\"verdict doubtful\">"));
  EXPECT_THAT(read_text(folder / "c.html"), HasSubstr("<strong id=\"verdict\">not met</strong>"));
  EXPECT_EQ(run_imulab(folder, "report c.json -o again.html").exit_code, 0);
  EXPECT_THAT(read_text(folder / "again.html"), HasSubstr("<strong id=\"verdict\">not met</strong>"));
  const CommandResult met = run_imulab(folder, calibrate + "--json --require 'accel.offset <= 100 mg'");
  EXPECT_EQ(met.exit_code, 0) << met.errors;
  const OrderedJson json = OrderedJson::parse(met.output);
  EXPECT_EQ(json["verdict"], "met");
  EXPECT_EQ(json["quality"]["verdict"], "good") << "the file keeps its fields";
  EXPECT_NE(json.begin().key(), "verdict");
  EXPECT_EQ(std::prev(json.end()).key(), "warnings");
  folder.write("printed.json", met.output);
  EXPECT_EQ(read_calibration(folder / "printed.json").serial, read_calibration(folder / "c.json").serial) << "it is still a calibration";
}

TEST(Verdict, OfABudget) {  // ctest: once
  const TemporaryFolder folder;
  folder.write("m.toml", drift_mission);
  expect_verdict(folder, "budget m.toml --runs 20 --require 'CEP <= 10 km, RMS <= 50 nmi/h'", "met", 0);
  expect_verdict(folder, "budget m.toml --runs 20 --require 'CEP <= 10 km, 95 % <= 1 m at 200 s'", "not met", 1);
  const CommandResult linear = run_imulab(folder, "budget m.toml --runs 0 --require 'CEP <= 10 km'");
  EXPECT_EQ(linear.exit_code, 0) << linear.errors;
  EXPECT_THAT(on_one_line(linear.output), HasSubstr("by the linear propagation, without a Monte Carlo"));
  for (const auto& [limit, message] : {std::pair{"CPE <= 1 m", "--require: CPE: no figure of this result; did you mean CEP?"},
                                       {"CEP <= 1 nm/h", "\"nm/h\" is no unit of CEP; did you mean nmi/h?"},
                                       {"CEP <= 1 m at 9000 s", "there are errors until 300 s"}}) {
    const CommandResult refused = run_imulab(folder, std::string("budget m.toml --runs 0 --require '") + limit + "'");
    EXPECT_EQ(refused.exit_code, 2) << limit;
    EXPECT_THAT(refused.errors, HasSubstr(message));
  }
  const OrderedJson plain = OrderedJson::parse(run_imulab(folder, "budget m.toml --runs 0 --json").output);
  EXPECT_TRUE(plain["verdict"].is_null());
  EXPECT_THAT(plain["headline"].get<std::string>(), HasSubstr("after 300 s: horizontal position error"));
}

TEST(Verdict, OfNoise) {  // ctest: once
  const TemporaryFolder folder;
  write_still_log(folder, 6000, still_readings);
  expect_verdict(folder, "noise session.toml --force -o noise.json --require 'gyro.N <= 0.5 deg/sqrt(h)'", "met", 0, true, false);
  expect_verdict(folder, "noise session.toml --force -o noise.json --require 'gyro.x.N <= 0.01 deg/sqrt(h)'", "not met", 1, true, false);
  expect_verdict(folder, "noise session.toml --force -o noise.json", "good", 0, false, false);  // the page begins with what is known
  folder.write("m.toml", drift_mission);
  EXPECT_EQ(run_imulab(folder, "budget m.toml --runs 0 --noise noise.json").exit_code, 0) << "what is written is still read";
  const CommandResult wrong = run_imulab(folder, "noise session.toml --require 'gyro.M <= 1 deg/h'");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--require: gyro.M: no figure of this result; did you mean gyro.N?"));
}

TEST(Verdict, OfANavigationAgainstItsTruth) {  // ctest: once
  const TemporaryFolder folder;
  folder.write("m.toml", drift_mission);
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml --errors -o flight").exit_code, 0);
  expect_verdict(folder, "navigate none flight --require 'horizontal <= 10 km at 200 s, vertical <= 1 m'", "met", 0);
  expect_verdict(folder, "navigate none flight --require 'horizontal <= 0.001 m at 200 s'", "not met", 1);
  ASSERT_EQ(run_shell(folder, "sed -i '/truth/d; /^file = \"truth.csv\"/d' flight/session.toml").exit_code, 0);
  const CommandResult without = run_imulab(folder, "navigate none flight --require 'horizontal <= 1 m'");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.errors, HasSubstr("--require: flight: has no truth"));
}

TEST(Verdict, OfAPredictionAndAPlan) {  // ctest: once
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure cheng-path -o p.toml").exit_code, 0);
  expect_verdict(folder, "predict p.toml --method hybrid --require 'gyro.matrix.diagonal <= 1000 ppm'", "met", 0);
  expect_verdict(folder, "predict p.toml --method hybrid --require 'gyro.matrix.diagonal <= 0.1 ppm'", "not met", 1);
  expect_verdict(folder, "plan --require 'gyro.matrix.off_diagonal <= 4 arcsec' --axes 2 --within 600", "met", 0);
}

/// One with uncertainties of two coefficients that is doubtful, as its file.
std::string doubtful_calibration() {
  Calibration c;
  c.method = "static", c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("gyro.offset.x")};
  c.model.gyro.raw_unit = "rad/s", c.model.accel.raw_unit = "m/s^2";
  c.covariance = Eigen::Vector2d(1e-8, 1e-14).asDiagonal();
  c.quality.verdict = Verdict::doubtful, c.quality.findings.append(Severity::doubt, {"a reason of its own"});
  return calibration_text(c);
}

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Verdict, OfADoubtfulCalibrationEveryVerbWarnsOnce) {  // ctest: once
  const TemporaryFolder folder;
  folder.write("m.toml", drift_mission);
  folder.write("c.json", doubtful_calibration());
  folder.write("with.toml", std::regex_replace(drift_mission, std::regex("grade = \"navigation\""), "calibration = \"c.json\""));
  folder.write("exact.json", calibration_text(Calibration{}));
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml -o flight").exit_code, 0);
  const std::string warning = "c.json: the calibration is doubtful; its errors may be larger than it states";
  for (const auto& [command, has_page] : {std::pair{"compensate c.json flight -o out.csv", false},
                                          {"export c.json --to csv -o out.txt", false},
                                          {"navigate c.json flight", true},
                                          {"budget m.toml --calibration c.json --runs 0", true},
                                          {"budget with.toml --runs 0", true},
                                          {"compare c.json exact.json", true},
                                          {"trajectory with.toml --errors -o erring", false}}) {
    const std::string line = command;
    const CommandResult result = run_imulab(folder, line + " --json" + (has_page ? " --report page.html" : ""));
    EXPECT_LE(result.exit_code, 1) << line << result.errors;
    EXPECT_EQ(times(result.errors, warning), 1u) << line << result.errors;
    const OrderedJson json = OrderedJson::parse(result.output);
    EXPECT_THAT(json["warnings"].get<std::vector<std::string>>(), testing::Contains(warning)) << line;
    if (!has_page) continue;
    folder.write("saved.json", result.output);
    EXPECT_EQ(run_imulab(folder, "report saved.json -o saved.html").exit_code, 0) << line;
    for (const char* page : {"page.html", "saved.html"}) EXPECT_EQ(times(read_text(folder / page), warning), 1u) << line << page;
  }
}

TEST(Mission, ItsVerticalChannelAndBarometerReachTheNavigation) {
  const TemporaryFolder folder;
  std::string mission = drift_mission;
  mission.replace(mission.find("\"fixed\""), 7, "\"aided\"\nbarometer = { bias_m = { fixed = 12 }, noise_m = 0.1 }");
  folder.write("m.toml", mission);
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml --errors -o flight").exit_code, 0);
  const CommandResult flown = run_imulab(folder, "navigate none flight --json");
  ASSERT_EQ(flown.exit_code, 0) << flown.errors;
  const OrderedJson data = OrderedJson::parse(flown.output);
  EXPECT_EQ(data["vertical"], "aided");
  EXPECT_THAT(data["position_error"]["up_m"].get<double>(), testing::AllOf(testing::Gt(3.), testing::Lt(20.))) << "it goes to the barometer's error";
  EXPECT_EQ(OrderedJson::parse(run_imulab(folder, "navigate none flight --vertical free --json").output)["vertical"], "free");
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml -o ideal").exit_code, 0);
  const OrderedJson ideal = OrderedJson::parse(run_imulab(folder, "navigate none ideal --json").output);
  EXPECT_LT(std::abs(ideal["position_error"]["up_m"].get<double>()), 0.1) << "an ideal barometer";
}

TEST(Mission, ItsBarometerIsReadTenTimesASecond) {
  const TemporaryFolder folder;
  std::string mission = drift_mission;
  mission.replace(mission.find("\"fixed\""), 7, "\"held\"");
  mission.replace(mission.find("duration_s = 300"), 16, "duration_s = 2");
  mission.replace(mission.find("rate_hz = 10"), 12, "rate_hz = 200");
  folder.write("m.toml", mission);
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml -o flight").exit_code, 0);
  const std::string heights = read_text(folder / "flight/barometer.csv");
  EXPECT_EQ(std::count(heights.begin(), heights.end(), '\n'), 22) << "a header, and both ends";
  EXPECT_THAT(heights, HasSubstr("\n1.900000000,"));
}

TEST(Mission, AUnitThatCannotAlignItselfIsToldWhatToGive) {
  const TemporaryFolder folder;
  std::string mission = drift_mission;
  mission.replace(mission.find("navigation"), 10, "tactical");
  folder.write("m.toml", mission + "start = { aligned_over_s = 300 }\n");
  EXPECT_THAT(run_imulab(folder, "budget m.toml --runs 0").errors, HasSubstr("a rest does not show the heading to these gyros"));
  folder.write("m.toml", mission + "start = { heading_arcmin = 30, tilt_arcmin = 2 }\n");
  EXPECT_THAT(run_imulab(folder, "budget m.toml --runs 0").errors, testing::Not(HasSubstr("heading")));
}

}  // namespace
}  // namespace imulab
