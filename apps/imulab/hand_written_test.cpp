// Every verb that takes a calibration works on one that was written by hand, or says why not.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/recorded_session.hpp"

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* written_by_hand = R"({"format": "imulab.calibration/1", "model": {
  "accel": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]},
  "gyro": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 3]]}}}
)";

/// The calibration h.json, the session of a handheld IMU and c.json of it. Made once.
class HandWritten : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    folder_->write("h.json", written_by_hand);
    hand_held_session().write(*folder_);
    ASSERT_EQ(run("calibrate session --method handheld -o c.json").exit_code, 0);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static CommandResult run(const std::string& arguments) { return run_imulab(*folder_, arguments); }
  static std::string text(const std::string& file) { return read_text(*folder_ / file); }
  static void expect_refused(const std::string& arguments, int exit_code, const std::string& words) {
    const CommandResult result = run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_THAT(on_one_line(result.errors), HasSubstr(words)) << arguments;
  }

  static TemporaryFolder* folder_;
};
TemporaryFolder* HandWritten::folder_ = nullptr;

std::vector<double> second_row(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line), std::getline(lines, line);
  std::vector<double> out;
  for (const std::string& field : SessionText::fields(line))
    if (!field.empty()) out.push_back(std::stod(field));  // a stream has flags, too
  return out;
}

TEST_F(HandWritten, Compensates) {
  const CommandResult result = run("compensate h.json session -o out.csv --report out.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const std::vector<double> in = second_row(text("session/recording.csv")), out = second_row(text("out.csv"));
  EXPECT_EQ(out, (std::vector<double>{in[0], in[1], in[2], 3 * in[3], 2 * in[4], in[5], in[6]}));
  EXPECT_NE(text("out.html").find("unnamed IMU"), std::string::npos);
  const CommandResult stream = run_shell(*folder_, "'" + command_path() + "' compensate h.json --session session - -o - < session/recording.csv");
  EXPECT_EQ(second_row(stream.output), out) << stream.errors;
}

TEST_F(HandWritten, IsComparedAsTheTruth) {
  const CommandResult result = run("compare c.json h.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.output), HasSubstr("B h.json (no uncertainties: taken as the truth; the rig's frame)"));
  folder_->write("other.json", std::string(written_by_hand) + " ");
  EXPECT_THAT(on_one_line(run("compare h.json other.json").output), HasSubstr("nothing to test: no coefficient has an uncertainty"));
}

TEST_F(HandWritten, IsExported) {
  const CommandResult header = run("export h.json --to c-header -o h.h");
  ASSERT_EQ(header.exit_code, 0) << header.errors;
  EXPECT_THAT(text("h.h"), HasSubstr("/* Calibration of an unnamed IMU, made with imulab.\n"));
  EXPECT_THAT(header.errors, AllOf(HasSubstr("does not say how the accelerometers were recorded: the header takes m/s^2"),
                                   HasSubstr("does not say how the gyros were recorded: the header takes rad/s")));
  for (const char* target : {"px4", "ardupilot", "vectornav", "csv"}) {
    const CommandResult result = run(std::string("export h.json --to ") + target);
    EXPECT_EQ(result.exit_code, 0) << target << result.errors;
    EXPECT_THAT(result.output, AllOf(HasSubstr("# Calibration of an unnamed IMU, for "), Not(HasSubstr("\"\"")))) << target;
  }
  EXPECT_EQ(run("export h.json --to json-matrix").exit_code, 0);
  expect_refused("export h.json --to kalibr", 2, "needs the noise of the IMU, and this calibration has none of its rests; expected a noise.json");
}

TEST_F(HandWritten, NavigatesWithoutBands) {
  SessionText session = hand_held_session();
  session.session +=
      "[initial]\ntime_s = 31\nlatitude_deg = 45\nlongitude_deg = 8\nheight_m = 0\nvelocity_enu_mps = [0, 0, 0]\nroll_deg = 0\npitch_deg = 0\n"
      "heading_deg = 90\n";
  session.write(*folder_, "flight");
  const CommandResult result = run("navigate h.json flight --vertical fixed --report n.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.errors), HasSubstr("warning: h.json: states no uncertainties; those of the solution take it as exact"));
  EXPECT_NE(text("n.html").find("the calibration has no uncertainties."), std::string::npos);
}

TEST_F(HandWritten, HasAPageThatInventsNothing) {
  const CommandResult result = run("report h.json -o h.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const std::string page = text("h.html");
  const auto says = [&](const std::string& part) { return page.find(part) != std::string::npos; };  // a failure would print the page
  EXPECT_TRUE(says("unnamed IMU"));
  EXPECT_TRUE(says("Values without uncertainties: there is nothing to judge."));
  EXPECT_TRUE(says("<th>angle and rate</th><td>not on record</td>"));
  EXPECT_FALSE(says("before and after each turn</td>"));
  EXPECT_FALSE(says("the recorder&#39;s clock"));
  EXPECT_FALSE(says(">nan"));
}

TEST_F(HandWritten, HasNoErrorsToBudgetAndNoPlaceInAFleet) {
  folder_->write("m.toml",
                 "format = \"imulab.mission/1\"\nrate_hz = 5\n[start]\nlatitude_deg = 47\nlongitude_deg = 8\nheight_m = 400\n"
                 "[[segment]]\nkind = \"accelerate\"\nto_mps = 20\nduration_s = 12\n[errors]\ngrade = \"navigation\"\nvertical = \"fixed\"\n");
  expect_refused("budget m.toml --runs 0 --calibration h.json", 2, "h.json: has no uncertainties; expected a calibration with its covariance");
  expect_refused("fleet add h.json --store f.db", 2, "h.json: has no uncertainties; expected a calibration with its covariance");
  expect_refused("verify h.json", 2, "h.json: has no hashes of recordings; expected a calibration that imulab made from files");
  EXPECT_EQ(run("trajectory m.toml -o trajectory --unit h.json").exit_code, 0);
}

TEST_F(HandWritten, IsAUnitToSimulate) {
  ASSERT_EQ(run("procedure six-position --rest 5 -o p.toml").exit_code, 0);
  const CommandResult result = run("simulate p.toml -o simulated --unit h.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(nlohmann::json::parse(text("simulated/truth.json"))["model"]["gyro"]["matrix"][2][2], 3.0);
}

TEST_F(HandWritten, AllItsProblemsAreSaidAtOnce) {
  folder_->write("wrong.json", R"({"format": "imulab.calibration/1", "model": {"accel": {"matrix": 1}, "gyro": {"ofset": [0, 0, 0]}}})");
  const CommandResult result = run("compensate wrong.json session -o wrong.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.errors,
            "imulab: wrong.json: model.accel.matrix: expected 3 rows of 3 numbers\n  wrong.json: model.gyro.matrix: is missing\n"
            "  wrong.json: model.gyro.ofset: is unknown; did you mean offset?\n");
}

}  // namespace
}  // namespace imulab
