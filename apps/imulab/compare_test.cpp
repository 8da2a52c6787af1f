#include "imulab/coefficient.hpp"
#include "imulab/files.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <cmath>
#include <filesystem>
#include <tuple>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

/// The accelerometers' offsets to 10 ug and one gyro element to 2 arcsec.
Calibration two_coefficients() {
  Calibration c;
  c.imu = "unit";
  c.method = "static";
  c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("gyro.matrix.xy")};
  c.covariance = Eigen::Vector2d(std::pow(10 * unit::ug, 2), std::pow(2 * unit::arcsec, 2)).asDiagonal();
  return c;
}

/// 5 ug and 20 arcsec from it.
Calibration truth() {
  Calibration c;
  c.model.accel.offset.x() = 5 * unit::ug;
  c.model.gyro.matrix(0, 1) = 20 * unit::arcsec;
  return c;
}

struct CompareCommand : ::testing::Test {
  TemporaryFolder folder;
  CompareCommand() {
    folder.write("calibration.json", calibration_text(two_coefficients()));
    folder.write("truth.json", calibration_text(truth()));
  }
};

TEST_F(CompareCommand, PrintsATableInUserUnitsAndMarksWhatDiffers) {
  EXPECT_THAT(run_imulab(folder, "compare calibration.json truth.json").output, Not(HasSubstr("accel.offset.x")));  // not significant
  const CommandResult result = run_imulab(folder, "compare calibration.json truth.json -v");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ContainsRegex("gyro.matrix.xy.*\naccel.offset.x +5 +10 ug +\\+0.5\n"));  // the significant first
  EXPECT_THAT(result.output, ContainsRegex("gyro.matrix.xy +20.0 +2.0 arcsec +\\+10.0\\*\n"));
  EXPECT_THAT(result.output, HasSubstr("1 of 2 coefficients differ significantly"));
  EXPECT_THAT(result.output, HasSubstr("2 coefficients together: chi2 = 100.2"));  // 0.5^2 + 10^2
  EXPECT_THAT(on_one_line(result.output), HasSubstr("quadratic and cubic terms are compared unrotated"));
  EXPECT_THAT(run_imulab(folder, "compare calibration.json truth.json -v").output, ContainsRegex("accel.offset.x +0 +4.903"));  // SI
  EXPECT_EQ(result.errors, "");
}

TEST_F(CompareCommand, JsonHasTheDocumentedShape) {
  const CommandResult result = run_imulab(folder, "compare calibration.json truth.json --json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const auto json = nlohmann::json::parse(result.output);
  const auto& x = json["coefficients"]["accel.offset.x"];
  EXPECT_EQ(x["a"], 0);
  EXPECT_EQ(x["b"], 5 * unit::ug);
  EXPECT_EQ(x["difference"], 5 * unit::ug);
  EXPECT_NEAR(x["sigmas"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(x["user"]["unit"], "ug");
  EXPECT_EQ(json["consistency"]["degrees_of_freedom"], 2);
  EXPECT_EQ(json["coefficients"].size(), 2u);
}

/// `offset_ug` from it, and as well known.
std::string shifted(double offset_ug) {
  Calibration c = two_coefficients();
  c.model.accel.offset.x() = offset_ug * unit::ug;
  return calibration_text(c);
}

TEST_F(CompareCommand, InsignificantRowsAreCountedInOneLine) {
  const CommandResult result = run_imulab(folder, "compare calibration.json truth.json");
  EXPECT_THAT(result.output, HasSubstr("1 coefficients do not differ significantly; --verbose lists them"));
}

// Calibrations of the same data differ by less than two that are independent.
TEST_F(CompareCommand, ThePageSaysWhatTheTerminalSays) {
  Calibration many = two_coefficients(), same = many;
  for (Calibration* c : {&many, &same}) {
    c->estimated = select_coefficients("accel.matrix.diagonal"), c->estimated.push_back(coefficient_index("accel.offset.x"));
    c->covariance = 1e-6 * Eigen::MatrixXd::Identity(4, 4);
  }
  same.estimated.push_back(coefficient_index("gyro.offset.x")), same.covariance = 1e-6 * Eigen::MatrixXd::Identity(5, 5);
  folder.write("many.json", calibration_text(many)), folder.write("same.json", calibration_text(same));
  const CommandResult result = run_imulab(folder, "compare many.json same.json --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const std::string page = read_text(folder / "page.html");
  EXPECT_THAT(on_one_line(result.output), HasSubstr("the differences are smaller than the stated uncertainties say"));
  EXPECT_THAT(page, HasSubstr("The differences are smaller than the stated uncertainties say."));
  EXPECT_THAT(page, Not(HasSubstr("as large as")));
  for (const std::string& text : {on_one_line(result.output), page})
    EXPECT_THAT(text, HasSubstr("4 coefficients do not differ significantly, 1 are not tested"));
}

TEST_F(CompareCommand, ATolerancePutsItsVerdictFirstAndIsTheExitCode) {
  for (const auto& [tolerance, code, begin] :
       {std::tuple{"gyro.matrix.xy <= 25 arcsec", 0, "met: gyro.matrix.xy differs by 20 arcsec; tolerance: gyro.matrix.xy <= 25 arcsec\n"},
        {"accel.offset.x <= 10 ug, gyro.matrix.xy <= 10 arcsec", 1, "not met: gyro.matrix.xy differs by 20 arcsec; tolerance: gyro.matrix.xy <= 10"},
        {"gyro.offset.x <= 1 deg/h", 1, "not met: gyro.offset.x is not determined in both"}}) {
    const CommandResult result = run_imulab(folder, std::string("compare calibration.json truth.json --tolerance '") + tolerance + "'");
    EXPECT_EQ(result.exit_code, code) << tolerance << result.errors;
    EXPECT_THAT(on_one_line(result.output), testing::StartsWith(on_one_line(begin)));
  }
  const auto json =
      nlohmann::json::parse(run_imulab(folder, "compare calibration.json truth.json --json --tolerance 'gyro.matrix.xy <= 10 arcsec'").output);
  EXPECT_EQ(json["requirements"][0]["met"], false);
  EXPECT_NEAR(json["requirements"][0]["reached"].get<double>(), 20 * unit::arcsec, 1e-9);
  EXPECT_EQ(run_imulab(folder, "compare calibration.json truth.json --tolerance 'gyro.matrix.xy <= 10 mm'").exit_code, 2);
}

TEST_F(CompareCommand, DatesSerialsAndTheChangePerYearAreStated) {
  for (const auto& [file, measured, scale] : {std::tuple{"spring.json", "2024-03-31", 0.0}, {"autumn.json", "2026-03-31", 100.0}}) {
    Calibration c = two_coefficients();
    c.serial = "012", c.measured = measured, c.model.accel.offset.x() = scale * unit::ug;
    folder.write(file, calibration_text(c));
  }
  const CommandResult result = run_imulab(folder, "compare spring.json autumn.json --report page.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.output), HasSubstr("serial number 012, measured 2024-03-31"));
  EXPECT_THAT(result.output, HasSubstr("2.00 years from A to B."));
  EXPECT_THAT(result.output, ContainsRegex("accel.offset.x +100 +14 ug +\\+7.1\\* +50.0\n"));
  const std::string page = read_text(folder / "page.html");
  EXPECT_NE(page.find("measured 2026-03-31"), std::string::npos);
  EXPECT_NE(page.find("<th>per year</th>"), std::string::npos);
}

TEST_F(CompareCommand, ResultsOfOneKindAreComparedAndAMixIsRefused) {
  folder.write("mission.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 5\n[start]\nlatitude_deg = 47\nlongitude_deg = 8\nheight_m = 400\n"
               "[[segment]]\nkind = \"accelerate\"\nto_mps = 200\nduration_s = 120\n");
  for (const std::string grade : {"navigation", "tactical"})
    folder.write(grade + ".json", run_imulab(folder, "budget mission.toml --runs 0 --json --grade " + grade).output);
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "tactical.json"))["grade"], "tactical");
  const CommandResult result = run_imulab(folder, "compare navigation.json tactical.json --report page.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, testing::StartsWith("horizontal RMS: navigation.json "));
  const CommandResult mix = run_imulab(folder, "compare navigation.json calibration.json");
  EXPECT_EQ(mix.exit_code, 2);
  EXPECT_THAT(mix.errors, HasSubstr("navigation.json: is a budget; expected calibrations alone, or other results alone"));
  const CommandResult grades = run_imulab(folder, "budget mission.toml --runs 0 --json --grade navigation,tactical");
  EXPECT_EQ(grades.exit_code, 0) << grades.errors;
  const auto json = nlohmann::json::parse(grades.output);
  ASSERT_EQ(json["budgets"].size(), 2u);
  EXPECT_EQ(json["budgets"][1]["grade"], "tactical");
  EXPECT_EQ(json["budgets"][1]["noise"], "the grade");
}

TEST_F(CompareCommand, SeveralStandSideBySide) {
  folder.write("b.json", shifted(10));
  folder.write("c.json", shifted(100));
  const CommandResult result = run_imulab(folder, "compare calibration.json b.json c.json truth.json -v");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("C  c.json (unit, static; the accelerometers' frame)\nD  truth.json (no uncertainties"));
  EXPECT_THAT(result.output, ContainsRegex("coefficient +B - A +C - A +D - A +sigmas\n"));
  // 10 and 100 ug with 14.1 ug of difference, 5 ug and 20 arcsec from the truth with A's own 10 ug and 2 arcsec
  EXPECT_THAT(result.output, ContainsRegex("accel.offset.x +\\+0.7 +\\+7.1\\* +\\+0.5\n"));
  EXPECT_THAT(result.output, ContainsRegex("gyro.matrix.xy +\\+0.0 +\\+0.0 +\\+10.0\\*\n"));
  const std::string sentences = on_one_line(result.output);
  EXPECT_THAT(sentences, testing::StartsWith("2 of 2 coefficients differ significantly (* beyond 3.1 sigma: 1 % for all together) "));  // six tests
  // A row a pair, the least probable first: 0.5^2 + 10^2, 100^2 / (2 * 10^2), 10^2 / (2 * 10^2)
  EXPECT_THAT(result.output, ContainsRegex("pair .*\nD - A +1 +2 +100.2 +2 +[0-9.e-]+ +larger: gyro.matrix.xy\n"
                                           "C - A +1 +2 +50 +2 +1.4e-11 +larger: accel.offset.x\nB - A +0 +2 +0.5 +2 +0.78 +as stated\n"));
  // 0, 10 and 100 ug with 10 ug each: 60.67 about their mean; the truth takes no part
  EXPECT_THAT(sentences, HasSubstr("All 3 calibrations about their weighted mean, 4 degrees of freedom: chi2 = 60.7, "));
  EXPECT_THAT(sentences, HasSubstr("are larger than the stated uncertainties say; given the others, most in accel.offset.x (+7.8 sigmas) "
                                   "Coefficients that differ among them: accel.offset.x A "));
}

TEST_F(CompareCommand, OfManyEachCoefficientIsOneRow) {
  std::string files;
  for (int k = 0; k < 8; ++k) {
    folder.write(std::to_string(k) + ".json", shifted(k == 5 ? 100 : k));
    files += " " + std::to_string(k) + ".json";
  }
  const CommandResult result = run_imulab(folder, "compare" + files);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ContainsRegex("coefficient +largest  in +pairs that differ\naccel.offset.x +\\+7.1\\*  F - A +1 of 7\n"));
}

TEST_F(CompareCommand, OfTwoCalibrationsAndATruthThereIsNothingMoreToSay) {
  folder.write("b.json", shifted(10));
  const CommandResult result = run_imulab(folder, "compare truth.json calibration.json b.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, Not(HasSubstr("weighted mean")));
  const auto json = nlohmann::json::parse(run_imulab(folder, "compare truth.json calibration.json b.json --json").output);
  EXPECT_EQ(json["comparisons"].size(), 2u);
  EXPECT_TRUE(json["agreement"].is_null());
}

TEST_F(CompareCommand, JsonOfSeveralHasTheDocumentedShape) {
  folder.write("b.json", shifted(10));
  folder.write("c.json", shifted(100));
  const CommandResult result = run_imulab(folder, "compare calibration.json b.json c.json --json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const auto json = nlohmann::json::parse(result.output);
  ASSERT_EQ(json["comparisons"].size(), 2u);
  EXPECT_EQ(json["comparisons"][1]["a"], "calibration.json");
  EXPECT_EQ(json["comparisons"][1]["b"], "c.json");
  EXPECT_EQ(json["comparisons"][1]["coefficients"]["accel.offset.x"]["difference"], 100 * unit::ug);
  const auto& joint = json["agreement"];
  EXPECT_EQ(joint["calibrations"], 3);
  EXPECT_EQ(joint["consistency"]["degrees_of_freedom"], 4);
  EXPECT_EQ(joint["coefficients"]["gyro.matrix.xy"]["chi2"], 0);
  EXPECT_NEAR(joint["coefficients"]["accel.offset.x"]["chi2"].get<double>(), 182.0 / 3, 1e-9);  // (0, 1, 10) about their mean; rounding
  EXPECT_EQ(joint["differing"], nlohmann::json::array({"accel.offset.x"}));
}

TEST_F(CompareCommand, ReadsOneFromStandardInput) {
  const CommandResult piped = run_shell(folder, "'" + command_path() + "' compare calibration.json - < truth.json");
  EXPECT_EQ(piped.exit_code, 0) << piped.errors;
  const CommandResult named = run_imulab(folder, "compare calibration.json truth.json");
  std::string expected = on_one_line(named.output);
  expected.replace(expected.find("truth.json"), 10, "standard input");
  EXPECT_EQ(on_one_line(piped.output), expected);
}

TEST_F(CompareCommand, TwoTruthsHaveNothingToTest) {
  folder.write("other.json", calibration_text(truth()));
  const CommandResult result = run_imulab(folder, "compare truth.json other.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("nothing to test"));
}

/// The calibration with one text in its file replaced.
std::string damaged(const std::string& from, const std::string& to) {
  std::string text = calibration_text(two_coefficients());
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(CompareCommand, WrongUseIsExplained) {
  folder.write("newer.json", "{\"format\": \"imulab.calibration/2\"}");
  folder.write("session.json", "{\"format\": \"imulab.session/1\"}");
  folder.write("result.json", run_imulab(folder, "compare calibration.json truth.json --json").output);
  folder.write("empty.json", "");
  folder.write("nan.json", damaged("1.0", "NaN"));
  folder.write("null.json", damaged("1.0", "null"));
  Calibration singular = two_coefficients(), counts = two_coefficients(), other = two_coefficients();
  singular.model.gyro.matrix.setZero();
  counts.model.gyro.raw_unit = "count";
  other.model.gyro.raw_unit = "rad/s";
  folder.write("singular.json", calibration_text(singular));
  folder.write("counts.json", calibration_text(counts));
  folder.write("rates.json", calibration_text(other));
  std::filesystem::create_symlink("calibration.json", folder / "link.json");
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c :
       {Case{"", "imulab: CALIBRATION is required"}, Case{"calibration.json", "imulab: CALIBRATION: At least 2 required but received 1"},
        Case{"calibration.json absent.json", "imulab: absent.json: cannot be opened: No such file"},
        Case{"calibration.json truth.json .", "imulab: .: is a folder; expected a file"},
        Case{"newer.json calibration.json",
             "imulab: newer.json: format: imulab.calibration/2 is a newer format; this program reads imulab.calibration/1"},
        Case{"calibration.json session.json", "imulab: session.json: format: expected \"imulab.calibration/1\", \"imulab.noise/1\""},
        Case{"calibration.json result.json", "imulab: result.json: is a comparison; expected calibrations alone, or other results alone"},
        Case{"calibration.json empty.json", "imulab: empty.json: is empty; expected calibration.json, noise.json, extrinsics.json, or what compare"},
        Case{"calibration.json - < /dev/null", "imulab: standard input: is empty; expected calibration.json"},
        Case{"calibration.json nan.json", "nan.json:28: not JSON; expected calibration.json"},
        Case{"calibration.json null.json", "expected a number, found null"},
        Case{"calibration.json truth.json singular.json", "imulab: singular.json: gyro.matrix is singular"},
        Case{"calibration.json counts.json rates.json",
             "imulab: rates.json: gyro was calibrated from rad/s, expected count as in counts.json"},  // and the first does not say
        Case{"calibration.json truth.json calibration.json",
             "imulab: calibration.json: the same file as calibration.json; a comparison takes the errors as independent; expected different"},
        Case{"calibration.json ./calibration.json", "imulab: ./calibration.json: the same file as calibration.json"},
        Case{"calibration.json link.json", "imulab: link.json: the same file as calibration.json"},
        Case{"- truth.json -", "imulab: -: standard input is named twice; expected it once"}}) {
    const CommandResult result = run_imulab(folder, std::string("compare ") + c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments;
    EXPECT_THAT(result.errors, HasSubstr(c.message)) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
  }
}

TEST_F(CompareCommand, NamesOfFilesOpenNoRowAndNoMessage) {
  folder.write("x\nimulab: F.json", calibration_text(two_coefficients()));
  folder.write("y\nimulab: F.json", "{");
  for (const char* arguments :
       {"compare 'x\nimulab: F.json' truth.json", "compare 'y\nimulab: F.json' truth.json", "compare '?\nimulab: F' truth.json"}) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_THAT(result.output + result.errors, Not(HasSubstr("\nimulab: F"))) << arguments;
    EXPECT_THAT(result.output + result.errors, HasSubstr("imulab: F")) << arguments;
  }
}

}  // namespace
}  // namespace imulab
