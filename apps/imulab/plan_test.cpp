#include "imulab/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include "tests/still_log.hpp"
#include <algorithm>
#include <sstream>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

struct PlanCommand : ::testing::Test {
  TemporaryFolder folder;

  void expect_ends(const std::string& arguments, int exit_code, const std::string& message) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(message)) << arguments;
  }
};

TEST_F(PlanCommand, WritesAProcedureThatPredictConfirms) {  // ctest: once
  const CommandResult result = run_imulab(folder, "plan --require 'gyro.matrix.off_diagonal <= 2 arcsec' --axes 2 -o p.toml");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");  // no terminal, no progress
  EXPECT_THAT(result.output, HasSubstr(" turns in "));
  EXPECT_THAT(result.output, HasSubstr("about the IMU's"));
  const Session session = read_session(folder / "p.toml");
  for (const Step& step : session.steps)
    if (step.kind == StepKind::rotate) {
      EXPECT_NE(step.axis, RigAxis::outer);
    }
  const CommandResult predicted = run_imulab(folder, "predict p.toml --method hybrid --json");
  const Json json = Json::parse(predicted.output);
  for (const char* name : {"gyro.matrix.xy", "gyro.matrix.zx"})
    EXPECT_LE(json.at("coefficients").at(name).at("cramer_rao").get<double>(), 2 * 4.8481368e-6) << predicted.errors;
}

TEST_F(PlanCommand, ThePageHasTheTurnsOfTheTableAndSaysWhatWasWritten) {  // ctest: once
  const CommandResult result = run_imulab(folder, "plan --require 'gyro.matrix.off_diagonal <= 5 arcsec' --axes 2 -o p.toml --report p.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("\nwritten: p.toml\n"));
  const std::string page = read_text(folder / "p.html");
  const auto says = [&](const std::string& part) { return page.find(part) != std::string::npos; };
  EXPECT_TRUE(says("<h1>Turns and rests for gyro misalignment to 5 arcsec</h1>"));
  EXPECT_TRUE(says("written: p.toml"));
  std::size_t turns = 0;
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find(" deg  rest "); at != std::string::npos) {
      ++turns;
      EXPECT_TRUE(says(fmt::format("<tr><th>{}</th><td class=\"left\">{}</td>", turns, line.substr(5, line.find(' ', 5) - 5)))) << line;
    }
  EXPECT_GT(turns, 2u);
  EXPECT_TRUE(says(fmt::format("<tr><th>{}</th>", turns)));
}

TEST_F(PlanCommand, TheSameBitsTwice) {  // ctest: once
  const char* arguments = "plan --require 'gyro.matrix.off_diagonal <= 4 arcsec' --axes 2 -o -";
  const CommandResult once = run_imulab(folder, arguments), again = run_imulab(folder, arguments);
  EXPECT_EQ(once.exit_code, 0) << once.errors;
  EXPECT_EQ(once.output, again.output);
  EXPECT_THAT(once.output, HasSubstr("format = \"imulab.session/1\""));
}

TEST_F(PlanCommand, SaysWhatCannotBeReached) {  // ctest: long
  expect_ends("plan --require 'accel.matrix.diagonal <= 10 ppm'", 1,
              "better than 31 ppm; gravity and the cubic term limit it; a measured value of gravity is more certain");
  expect_ends("plan --require 'gyro.matrix.xx <= 10 ppm' --axes 1", 1, "gyro.matrix.xx has ");
  expect_ends("plan --require 'accel.offset <= 1 ug' --within 600", 1, "no path was found that meets the requirements: accel.offset.");
}

TEST_F(PlanCommand, LeavesAMarginAndSaysSo) {  // ctest: once
  const std::string plan = "plan --require 'gyro.matrix.off_diagonal <= 4 arcsec' --axes 2 --effects none --json";
  const Json with = Json::parse(run_imulab(folder, plan).output), without = Json::parse(run_imulab(folder, plan + " --margin 1").output);
  EXPECT_EQ(with["verdict"], "met");
  EXPECT_EQ(with["margin"], 0.8);
  EXPECT_THAT(with["headline"].get<std::string>(), testing::ContainsRegex("uncertainties at most 0\\.([0-7][0-9]?|80?) of what is required"));
  double worst = 0, at_limit = 0;
  for (const char* name : {"gyro.matrix.xy", "gyro.matrix.yx", "gyro.matrix.zx"}) {
    worst = std::max(worst, with["coefficients"][name]["closed_form"].get<double>());
    at_limit = std::max(at_limit, without["coefficients"][name]["closed_form"].get<double>());
  }
  constexpr double limit = 4 * 4.84813681e-6;
  EXPECT_LE(worst, 0.8 * limit * 1.001);
  EXPECT_LE(at_limit, limit);
  EXPECT_GT(at_limit, 0.8 * limit);
  EXPECT_LT(without["duration_s"], with["duration_s"]);
}

TEST_F(PlanCommand, CountsTheNoiseOfTheUnit) {  // ctest: once
  write_still_log(folder, 6000, still_readings);
  ASSERT_EQ(run_imulab(folder, "noise session.toml -o white.json").exit_code, 0);
  Json noise = Json::parse(read_text(folder / "white.json"));
  for (Json& axis : noise["axes"])
    if (axis["name"].get<std::string>().starts_with("gyro"))
      axis["coefficients"]["B"] = {{"value", 1e-3}, {"standard_uncertainty", 1e-4}, {"lower", 8e-4}, {"upper", 1.2e-3}, {"determined", true}};
  folder.write("flicker.json", noise.dump());
  const auto sigma = [&](const std::string& more) {
    const std::string plan = "plan --require 'gyro.offset <= 0.01 deg/h' --within 300 --rest 30 --effects none --json";
    return Json::parse(run_imulab(folder, plan + more).output)["coefficients"]["gyro.offset.x"]["closed_form"].get<double>();
  };
  EXPECT_GT(sigma(" --noise white.json"), 3 * sigma(""));
  EXPECT_GT(sigma(" --noise flicker.json"), 3 * sigma(" --noise white.json"));
}

TEST_F(PlanCommand, RefusesBadInput) {  // ctest: once
  expect_ends("plan", 2, "--require");
  expect_ends("plan --require 'gyro.matrix.xx <= 10 ug'", 2, "\"ug\" is no unit of gyro.matrix.xx");
  expect_ends("plan --require 'accel.matrix.xy <= 1 arcsec'", 2, "lower triangular");
  expect_ends("plan --require 'accel.offset <= 5 ug' --axes 4", 2, "--axes: 4; expected 1, 2, 3, hand, or names such as outer,inner");
  expect_ends("plan --require 'accel.offset <= 5 ug' --grade best", 2, "best");
  expect_ends("plan --require 'accel.offset <= 5 ug' --latitude 91", 2, "expected a number from -90 to 90");
  expect_ends("plan --require 'accel.offset <= 5 ug' --within 0.1", 2, "expected a number from 60 to 14400");
  expect_ends("plan --require 'accel.offset <= 5 ug' --rest 7.5", 2, "expected a whole number from 6 to 600");
  expect_ends("plan --require 'accel.offset <= 5 ug' --within 60 --rest 60", 2, "no turn and rest fit into the time");
}

TEST_F(PlanCommand, PredictNamesWhatIsOpenAndWhatHelps) {  // ctest: once
  EXPECT_EQ(run_imulab(folder, "procedure six-position -o six.toml").exit_code, 0);
  expect_ends("predict six.toml --method hybrid --runs 100", 2, "--runs: belongs to --method turntable");
  EXPECT_EQ(run_imulab(folder, "procedure cheng-path -o p.toml").exit_code, 0);
  const CommandResult result = run_imulab(folder, "predict p.toml --method hybrid");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("gyro.matrix.zz"));
  expect_ends("predict p.toml --method hybrid --require 'gyro.matrix.diagonal <= 0.1 ppm'", 1, "the requirements are not met: gyro.matrix.xx has ");
}

TEST_F(PlanCommand, APlanForAHandCalibratesAsItPromises) {  // few rests, whose gyros differ by the Earth's rate  // ctest: once
  const char* require = "'gyro.matrix.diagonal <= 30 ppm, gyro.matrix.off_diagonal <= 20 arcsec, accel.offset <= 20 ug'";
  ASSERT_EQ(run_imulab(folder, std::string("plan --axes hand --require ") + require + " -o hand.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate hand.toml -o hand").exit_code, 0);
  const CommandResult calibrated = run_imulab(folder, "calibrate hand --method hybrid -o hand.json");
  EXPECT_EQ(calibrated.exit_code, 0) << calibrated.output << calibrated.errors;
  EXPECT_THAT(run_imulab(folder, "compare hand.json hand/truth.json").output,
              testing::ContainsRegex("^0 of [0-9]+ coefficients differ significantly"));
}

}  // namespace
}  // namespace imulab
