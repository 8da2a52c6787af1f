#include "imulab/coefficient.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

constexpr const char* head = R"(format = "imulab.session/1"
[imu]
name = "unit"
grade = "navigation"
[site]
latitude_deg = 45
height_m = 0
[rig]
kind = "turntable"
angle_sigma_arcsec = 2
orthogonality_sigma_arcsec = 2
zero_sigma_arcsec = 2
timing_sigma_ms = 10
)";

/// Six faces and a turn about each axis.
constexpr const char* steps = R"([[step]]
kind = "hold"
duration_s = 60
[[step]]
kind = "rotate"
axis = "outer"
angle_deg = 720
rate_dps = 10
[[step]]
kind = "hold"
duration_s = 60
[[step]]
kind = "rotate"
axis = "middle"
angle_deg = 720
rate_dps = 10
[[step]]
kind = "hold"
duration_s = 60
[[step]]
kind = "rotate"
axis = "inner"
angle_deg = 720
rate_dps = 10
[[step]]
kind = "hold"
duration_s = 60
[[step]]
kind = "hold"
inner_deg = 90
duration_s = 60
[[step]]
kind = "hold"
inner_deg = 180
duration_s = 60
[[step]]
kind = "hold"
inner_deg = 270
duration_s = 60
[[step]]
kind = "hold"
inner_deg = 0
middle_deg = 90
duration_s = 60
[[step]]
kind = "hold"
middle_deg = -90
duration_s = 60
)";

/// The procedure with one text replaced.
std::string with(const std::string& from, const std::string& to) {
  std::string text = std::string(head) + steps;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

struct PredictCommand : ::testing::Test {
  TemporaryFolder folder;
  PredictCommand() { folder.write("p.toml", std::string(head) + steps); }

  void expect_refused(const std::string& arguments, const std::string& message) {
    const CommandResult result = run_imulab(folder, "predict " + arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.errors, HasSubstr("imulab: " + message)) << arguments;
    EXPECT_EQ(result.output, "") << arguments;
  }
};

TEST_F(PredictCommand, HoldsNeedSamples) {
  folder.write("slow.toml", std::string(head) + R"([[recording]]
file = "r.csv"
rate_hz = 0.02
time = { column = "t", unit = "s" }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "rad/s" }
accel = { columns = ["ax", "ay", "az"], output = "rate", unit = "m/s^2" }
)" + steps);
  expect_refused("slow.toml", "slow.toml: step 1 (hold at 0 s): 1.2 samples at 0.02 Hz; expected two or more");
}

TEST_F(PredictCommand, PrintsATableInUserUnitsWithTheShares) {
  const CommandResult result = run_imulab(folder, "predict p.toml --runs 1000");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");  // no terminal, no progress
  EXPECT_THAT(result.output, HasSubstr("Standard uncertainty of every coefficient, shares of its variance in percent,\n"));
  EXPECT_THAT(result.output, ContainsRegex("coefficient +unit +sigma +rig +site +noise +term +eff. +largest\n"));
  EXPECT_THAT(result.output, ContainsRegex("accel.matrix.xx +ppm +3[12] .* (9[3-8]) .* gravity\n"));  // g alone: 3e-4 of 9.806 m/s^2
  EXPECT_THAT(result.output, ContainsRegex("gyro.offset.x +deg/h +0.00[0-9]+ "));
  EXPECT_THAT(result.output, ContainsRegex("Monte Carlo: 1000 procedures. At most [0-9.]+ % from the closed form"));
  EXPECT_THAT(result.output, Not(HasSubstr("nan")));
  std::istringstream lines(result.output);
  std::size_t rows = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 80u);
    rows += line.starts_with("accel.") || line.starts_with("gyro.");
  }
  EXPECT_EQ(rows, 45u);
}

TEST_F(PredictCommand, EvenWithEverySourceLinesStayShort) {
  folder.write("full.toml", with("grade = \"navigation\"\n[site]", "grade = \"mems\"\nnoise = \"full\"\n[site]\nlatitude_sigma_deg = 1"));
  const CommandResult result = run_imulab(folder, "predict full.toml --runs 100");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ContainsRegex("sigma [^\n]* largest\n"));
  EXPECT_THAT(result.output, ContainsRegex("accel.offset.x +ug +5000 "));  // 5 mg of turn-on bias
  EXPECT_THAT(result.output, HasSubstr("gyro.g_sensitivity.zz deg/h/g "));
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u);
}

TEST_F(PredictCommand, WithoutRunsThereIsNoMonteCarlo) {
  const CommandResult result = run_imulab(folder, "predict p.toml --runs 0");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, Not(HasSubstr("Carlo")));
  EXPECT_FALSE(Json::parse(run_imulab(folder, "predict p.toml --runs 0 --json").output)["coefficients"]["gyro.offset.x"].contains("monte_carlo"));
}

TEST_F(PredictCommand, JsonHasTheDocumentedShape) {
  const CommandResult result =
      run_imulab(folder, "predict p.toml --runs 1000 --json --require 'gyro.matrix <= 500 ppm, accel.matrix.diagonal <= 6 ppm'");
  EXPECT_EQ(result.exit_code, 1);  // g
  const Json json = Json::parse(result.output);
  ASSERT_EQ(json["coefficients"].size(), 45u);
  for (const auto& [name, c] : json["coefficients"].items()) {
    const double closed = c["closed_form"], first = c["first_order"], second = c["second_order"];
    EXPECT_GT(closed, 0) << name;
    EXPECT_NEAR(closed, std::hypot(first, second), 1e-12 * closed) << name;                  // rounding
    EXPECT_NEAR(c["cramer_rao"].get<double>(), first, 1e-12 * closed) << name;               // least squares with the right weights
    EXPECT_NEAR(c["monte_carlo"].get<double>() / closed, 1, 4.5 / std::sqrt(2000)) << name;  // 4.5 sigmas of 1000 draws
    double sum = 0;
    for (const auto& [source, sigma] : c["budget"].items()) sum += std::pow(sigma.get<double>(), 2);
    EXPECT_NEAR(std::sqrt(sum), first, 1e-12 * closed) << name;
    EXPECT_NO_THROW(coefficient_index(name));
  }
  EXPECT_NEAR(json["coefficients"]["accel.matrix.xx"]["budget"]["gravity"].get<double>(), 3e-4 / 9.806, 1e-7);  // WGS-84: 9.8062
  EXPECT_EQ(json["monte_carlo_runs"], 1000);
  EXPECT_EQ(json["undetermined"], Json::array());
  ASSERT_EQ(json["requirements"].size(), 2u);
  EXPECT_EQ(json["requirements"][0]["requirement"], "gyro.matrix <= 500 ppm");
  EXPECT_EQ(json["requirements"][0]["met"], true);
  EXPECT_EQ(json["requirements"][1]["met"], false);
  EXPECT_EQ(json["requirements"][1]["limit"], 6e-6);
  EXPECT_GT(json["requirements"][1]["reached"].get<double>(), 6e-6);
  ASSERT_EQ(json["not_met"].size(), 1u);
  EXPECT_EQ(json["not_met"][0]["selector"], "accel.matrix.diagonal");
  EXPECT_EQ(json["not_met"][0]["source"], "gravity");
  EXPECT_EQ(json["not_met"][0]["limit"], 6e-6);
  EXPECT_EQ(json["considered"].size(), 9u);  // accel.cubic, gyro.quadratic, gyro.cubic
  EXPECT_NEAR(json["priors"]["accel.cubic"].get<double>() * 9.80665 * 9.80665, 5e-6, 1e-12);
  EXPECT_NEAR(json["coefficients"]["accel.matrix.xx"]["budget"]["accel.cubic"].get<double>(), 5e-6, 1e-7);
  for (const char* knob : {"table", "timing", "imu", "all"}) {
    EXPECT_TRUE(json["tolerance"][knob]["others_as_declared"]["factor"].is_null()) << knob;
    EXPECT_EQ(json["tolerance"][knob]["others_as_declared"]["not_met"][0]["source"], "gravity") << knob;
  }
  const Json& alone = json["tolerance"]["imu"]["others_perfect"];  // with g known, the unit alone decides, and its cubic term of 5 ppm
  EXPECT_GT(alone["factor"], 0);
  EXPECT_NEAR(alone["gyro_noise_density"].get<double>() / alone["factor"].get<double>(), 0.001 * std::acos(-1.0) / 180 / 60, 1e-12);
}

TEST_F(PredictCommand, AnswersTheInverseQuestion) {
  const CommandResult met = run_imulab(folder, "predict p.toml --runs 0 --require 'gyro.matrix.off_diagonal <= 5 arcsec, accel.offset <= 20 ug'");
  EXPECT_EQ(met.exit_code, 0) << met.errors;
  const std::string answers = on_one_line(met.output);
  EXPECT_THAT(answers, HasSubstr("As declared, every requirement is met. "));
  EXPECT_THAT(answers, ContainsRegex("coarsest table all else perfect 1.[0-9]+ x declared: angle, orthogonality, zero [23].[0-9]+ arcsec "));
  EXPECT_THAT(answers, ContainsRegex("longest timing error of a turn all else perfect any, tried up to 300 x declared: timing 3000 ms "));
  EXPECT_THAT(answers, ContainsRegex("noisiest unit all else perfect .* noise [0-9.]+ deg/sqrt\\(h\\) and [0-9.]+ ug/sqrt\\(Hz\\) "));

  const CommandResult missed = run_imulab(folder, "predict p.toml --runs 0 --require 'gyro.matrix.off_diagonal <= 1 arcsec'");
  EXPECT_EQ(missed.exit_code, 1);
  EXPECT_THAT(missed.output, testing::StartsWith("not met: gyro.matrix."));
  EXPECT_THAT(missed.errors, HasSubstr("they are with the table, timing and noise that were found"));  // not as declared, but by a better table
  EXPECT_THAT(on_one_line(missed.output),
              ContainsRegex("As declared, these requirements are not met: gyro.matrix.off_diagonal <= 1 arcsec: gyro.matrix.[xyz]+ has "
                            "[0-9.]+ arcsec, most of it from (orthogonality|zero|angle) "));
  EXPECT_THAT(on_one_line(missed.output), ContainsRegex("all else as declared 0.[0-9]+ x declared: angle, orthogonality, zero 0.[0-9]+ arcsec "));

  const CommandResult never = run_imulab(folder, "predict p.toml --runs 0 --require 'accel.matrix.diagonal <= 1 ppm'");
  EXPECT_EQ(never.exit_code, 1);
  EXPECT_THAT(
      on_one_line(never.output),
      ContainsRegex("all else as declared none: not even a perfect table accel.matrix.diagonal <= 1 ppm: accel.matrix.[a-z]+ has 3[12][.0-9]* "
                    "ppm, most of it from gravity "));
  EXPECT_THAT(never.errors, HasSubstr("imulab: the requirements are not met with this procedure, not even with a hundredth of "));
}

TEST_F(PredictCommand, WhatTheProcedureLeavesOpenIsNamedAndTheRestPrinted) {
  folder.write("open.toml", std::string(head) +
                                "[[step]]\nkind = \"hold\"\nduration_s = 60\n[[step]]\nkind = \"hold\"\ninner_deg = 90\nduration_s = 60\n"
                                "[[step]]\nkind = \"hold\"\ninner_deg = 180\nduration_s = 60\n");
  const CommandResult result = run_imulab(folder, "predict open.toml --runs 1000 --require 'gyro.matrix <= 100 arcsec'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, ContainsRegex("imulab: the procedure does not determine: .*accel.matrix.xx.* gyro.matrix.xx"));
  EXPECT_THAT(result.output, HasSubstr("\naccel.offset.z "));
  EXPECT_THAT(result.output, Not(HasSubstr("\naccel.matrix.xx ")));
  EXPECT_THAT(result.output, HasSubstr("not det.:"));
  EXPECT_THAT(on_one_line(result.output), HasSubstr("Monte Carlo: 1000 procedures, without what is not determined. "));
  EXPECT_THAT(on_one_line(result.output), HasSubstr("gyro.matrix <= 100 arcsec: the procedure does not determine gyro.matrix.x"));
  const Json json = Json::parse(run_imulab(folder, "predict open.toml --runs 0 --json").output);
  EXPECT_EQ(json["coefficients"].size() + json["undetermined"].size(), 45u);
  EXPECT_TRUE(std::count(json["undetermined"].begin(), json["undetermined"].end(), "accel.matrix.xx"));
}

TEST_F(PredictCommand, WithoutALatitudeEarthsRateIsASource) {
  folder.write("nowhere.toml", with("latitude_deg = 45\nheight_m = 0\n", "gravity_mps2 = 9.8\n"));
  const CommandResult result = run_imulab(folder, "predict nowhere.toml --runs 0 -v");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ContainsRegex(" Earth [^\n]*\ncoefficient [^\n]* rate [^\n]*\n"));
}

TEST_F(PredictCommand, TheSameSeedPrintsTheSame) {
  const auto output = [&](const char* seed) { return run_imulab(folder, std::string("predict p.toml --runs 300 --seed ") + seed).output; };
  const std::string seven = output("7");
  EXPECT_EQ(seven, output("7"));
  EXPECT_NE(seven, output("8"));
}

TEST_F(PredictCommand, AProcedureThatWasRecordedIsPredictedAlike) {
  folder.write("six.toml", run_imulab(folder, "procedure six-position --rest 2").output);
  ASSERT_EQ(run_imulab(folder, "simulate six.toml -o six").exit_code, 0);
  const CommandResult planned = run_imulab(folder, "predict six.toml --runs 0"), recorded = run_imulab(folder, "predict six --runs 0");
  EXPECT_EQ(planned.output, recorded.output);
  EXPECT_FALSE(planned.output.empty());
}

TEST_F(PredictCommand, AProcedureThatIsWrongIsExplained) {
  struct Case {
    const char *from, *to, *message;
  };
  const std::string file = "w.toml";
  for (const Case& c :
       {Case{"kind = \"turntable\"", "kind = \"none\"", ": the rig is of kind \"none\"; the method turntable expects \"turntable\""},
        Case{"duration_s = 60", "duration_s = 0", ":16: step.duration_s: 0 is out of range; expected more than 0"},
        Case{"duration_s = 60", "duration_s = -1", ":16: step.duration_s: -1 is out of range"},
        Case{"\nangle_sigma_arcsec = 2", "\nangle_sigma_arcsec = -2", ":10: rig.angle_sigma_arcsec: -2 is out of range; expected at least 0"},
        Case{"timing_sigma_ms = 10", "timing_sigma_ms = nan", ":13: rig.timing_sigma_ms: "},
        Case{"angle_deg = 720", "", ": step.angle_deg: is missing"},
        Case{"angle_deg = 720", "angle_deg = 0", ": step.angle_deg: is 0; expected a turn"},
        Case{"rate_dps = 10", "rate_dps = 0", ": step.rate_dps: 0 is out of range; expected more than 0"},
        Case{"axis = \"outer\"", "axis = \"upper\"", ": step.axis: \"upper\" is not allowed; expected one of "},
        Case{"latitude_deg = 45\nheight_m = 0\n", "", ": neither gravity nor latitude of the site is given"},
        Case{"grade = \"navigation\"\n", "", ": the IMU's noise is not declared"},
        Case{"grade = \"navigation\"\n", "accel_noise_density = 5e-5\n", ": the IMU's noise is not declared"},
        Case{"grade = \"navigation\"\n", "grade = \"navigation\"\ngyro_noise_density = 0\n", ": the gyro noise density is 0; expected one above 0"},
        Case{steps, "", ": "}}) {
    folder.write(file, with(c.from, c.to));
    const CommandResult result = run_imulab(folder, "predict w.toml --runs 0");
    EXPECT_EQ(result.exit_code, 2) << c.to;
    EXPECT_THAT(result.errors, testing::StartsWith("imulab: w.toml:")) << c.to;
    const std::string message = std::string(c.message);
    EXPECT_THAT(result.errors, HasSubstr(message.substr(message[1] == ' ' ? 2 : 0))) << c.to;
    EXPECT_EQ(result.output, "") << c.to;
  }
}

/// In a session, steps have times of their own.
TEST_F(PredictCommand, StepsThatOverlapOrRunBackwardsAreExplained) {
  const std::string recording = R"([[recording]]
file = "recording.csv"
time = { column = "t", unit = "s" }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "rad/s" }
accel = { columns = ["ax", "ay", "az"], output = "rate", unit = "m/s^2" }
)";
  const auto hold = [](int start, int end) {
    return "[[step]]\nkind = \"hold\"\nstart_s = " + std::to_string(start) + "\nend_s = " + std::to_string(end) + "\n";
  };
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {hold(0, 60) + hold(50, 100), "w.toml:"}, {hold(100, 160) + hold(0, 60), "w.toml:"}, {hold(0, 0), "w.toml:"}}) {
    folder.write("w.toml", head + recording + text);
    expect_refused("w.toml --runs 0", message);
  }
  std::string second = recording;
  second.replace(second.find("recording.csv"), 13, "second.csv");
  folder.write("w.toml", head + recording + second + "[[step]]\nrecording = \"second.csv\"\nkind = \"hold\"\nstart_s = 0\nend_s = 60\n");
  expect_refused("w.toml --runs 0", "w.toml: 2 recordings; expected a procedure with one");
}

TEST_F(PredictCommand, ACommandThatIsWrongIsExplained) {
  folder.write("hand.toml", run_imulab(folder, "procedure handheld").output);
  expect_refused("", "procedure is required");
  expect_refused("nowhere.toml", "nowhere.toml: cannot be opened: No such file");
  expect_refused("hand.toml", "hand.toml: the rig is of kind \"none\"; the method turntable expects \"turntable\"");
  for (const char* runs : {"-1", "1", "99", "1000000001", "99999999999999999999", "1e3", "abc", "''"})
    expect_refused(std::string("p.toml --runs ") + runs, "--runs: ");
  expect_refused("p.toml --require ''", "--require: \"\": expected COEFFICIENTS <= NUMBER UNIT");
  expect_refused("p.toml --require 'accel.ofset <= 1 ug'", "--require: unknown coefficient \"accel.ofset\"");
  expect_refused("p.toml --require 'accel.offset <= 1 arcsec'", "--require: accel.offset <= 1 arcsec: \"arcsec\" is no unit of accel.offset");
  for (const char* limit : {"nan", "inf", "-1", "0"})
    expect_refused(std::string("p.toml --require 'accel.offset <= ") + limit + " ug'",
                   "--require: accel.offset <= " + std::string(limit) + " ug: expected a number above 0");
  expect_refused("p.toml --terms accel.offset,accel.matrix,gyro.offset,gyro.matrix --require 'gyro.g_sensitivity <= 1 deg/h/g'",
                 "gyro.g_sensitivity: gyro.g_sensitivity.xx is not among the terms to be estimated");
  expect_refused("p.toml --terms accel.cubic", "--terms: accel.cubic.x is not a coefficient that the method turntable estimates");
  expect_refused("p.toml --classical --terms accel.offset", "--terms: ");
}

}  // namespace
}  // namespace imulab
