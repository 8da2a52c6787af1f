// imulab budget, and trajectory --errors, as a user types them.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <cmath>
#include <filesystem>
#include <vector>

namespace imulab {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

const std::string motion = R"(format = "imulab.mission/1"
rate_hz = 10
[start]
latitude_deg = 45
longitude_deg = 8
height_m = 400
speed_mps = 100
[[segment]]
kind = "straight"
duration_s = 120
)";

std::string budget_mission(const std::string& errors) { return motion + "[errors]\n" + errors; }

TEST(BudgetCommand, SaysTheErrorsOfEachSourceAtTheEnd) {
  const TemporaryFolder folder;
  folder.write("m.toml", budget_mission("vertical = \"fixed\"\naccel = { bias_ug = { fixed = 100 } }\ngyro = { bias_deg_per_h = 1 }\n"
                                        "start = { position_m = 3 }\n"));
  const CommandResult r = run_imulab(folder, "budget m.toml --runs 400 --json");
  ASSERT_EQ(r.exit_code, 0) << r.errors;
  const Json out = Json::parse(r.output);
  EXPECT_EQ(out["vertical"], "fixed");
  EXPECT_EQ(out["time_s"], 120);
  // Heading north for 120 s: a bias b moves by b t^2/2 (1 - (W t)^2/12), W = 2 pi / 84.4 min; 1 %: Coriolis and the Earth's turning.
  const double b = 100e-6 * 9.80665, t = 120, schuler = 1 - std::pow(2 * M_PI / 5064 * t, 2) / 12;
  EXPECT_NEAR(out["sources"]["accelerometer bias"]["position_m"]["fixed"][0].get<double>(), b * t * t / 2 * schuler, 0.01 * b * t * t / 2);
  EXPECT_EQ(out["sources"]["accelerometer bias"]["position_m"]["sigma"][0], 0);
  // A drift d about north tilts gravity: g d t^3/6.
  const double drift = M_PI / 180 / 3600, east = 9.806 * drift * t * t * t / 6;
  EXPECT_NEAR(out["sources"]["gyro bias"]["position_m"]["sigma"][0].get<double>(), east, 0.02 * east);
  EXPECT_NEAR(out["sources"]["start position"]["position_m"]["sigma"][1].get<double>(), 3, 0.01);
  // Sampled sigmas of 400 runs: within four of their own sigmas, 14 %.
  const double linear = out["total"]["position_m"]["sigma"][0].get<double>();
  EXPECT_NEAR(out["monte_carlo"]["pe"]["sigma"].get<double>(), linear, 0.14 * linear);
  EXPECT_GT(out["coefficients"].size(), 5u);
  for (const char* quantity : {"pe", "vn", "au"}) {
    double sum = 0;
    for (const auto& [source, shares] : out["shares"].items()) sum += shares[quantity].get<double>();
    EXPECT_NEAR(sum, 1, 1e-9) << quantity;
  }
}

TEST(BudgetCommand, WritesGrowthOverTimeAndPrintsATable) {
  const TemporaryFolder folder;
  folder.write("m.toml", budget_mission("grade = \"navigation\"\nvertical = \"held\"\nbarometer = { bias_m = 5, noise_m = 1 }\n"));
  const CommandResult r = run_imulab(folder, "budget m.toml --runs 20 --every 30 -o out");
  ASSERT_EQ(r.exit_code, 0) << r.errors;
  EXPECT_THAT(on_one_line(r.output), testing::ContainsRegex("after 120 s: horizontal position error [0-9.]+ m RMS, height held by a barometer"));
  EXPECT_THAT(r.output, HasSubstr("gyro bias"));
  EXPECT_THAT(on_one_line(r.output), HasSubstr("nmi/h RMS, CEP"));
  const std::string total = read_text(folder / "out" / "total.csv");
  EXPECT_THAT(total, testing::StartsWith("t,pe_fixed,pe_sigma,"));
  EXPECT_EQ(std::count(total.begin(), total.end(), '\n'), 1 + 4);
  EXPECT_THAT(read_text(folder / "out" / "sources.csv"), HasSubstr("\nbarometer,120,"));
  EXPECT_THAT(read_text(folder / "out" / "monte_carlo.csv"), HasSubstr("ph_median"));
  const std::string runs = read_text(folder / "out" / "runs.csv");
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 1 + 20);
  // One seed gives the same bits; another grade's sensors give other figures.
  EXPECT_EQ(run_imulab(folder, "budget m.toml --runs 20").output, r.output);
  EXPECT_NE(run_imulab(folder, "budget m.toml --runs 20 --grade tactical").output, r.output);
}

TEST(BudgetCommand, TakesWhatACalibrationLeaves) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure six-position --rest 20 -o p.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate p.toml -o s").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "calibrate s --method turntable --terms accel.offset,accel.matrix,gyro.offset -o c.json").exit_code, 0);
  folder.write("m.toml", budget_mission("calibration = \"c.json\"\nvertical = \"fixed\"\n"));
  const CommandResult r = run_imulab(folder, "budget m.toml --runs 0 --json");
  ASSERT_EQ(r.exit_code, 0) << r.errors;
  const Json out = Json::parse(r.output), c = Json::parse(read_text(folder / "c.json"));
  EXPECT_EQ(out["coefficients"].size(), c["covariance"]["coefficients"].size());
  const double sigma = c["standard_uncertainty"]["accel"]["offset"][0].get<double>();
  EXPECT_NEAR(out["coefficients"]["accel.offset.x"]["position_m"]["sigma"][0].get<double>(), sigma * 120 * 120 / 2, 0.01 * sigma * 7200);
  EXPECT_EQ(run_imulab(folder, "budget m.toml --runs 0 --json --calibration c.json").output, r.output);
}

TEST(BudgetCommand, AnErringUnitsRecordingNavigatesAsTheBudgetSays) {
  const TemporaryFolder folder;
  folder.write("m.toml", budget_mission("vertical = \"fixed\"\naccel = { bias_ug = { fixed = 100 } }\n"));
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml --errors -o flight").exit_code, 0);
  const CommandResult r = run_imulab(folder, "navigate none flight --vertical fixed --json");
  ASSERT_EQ(r.exit_code, 0) << r.errors;
  const Json budget = Json::parse(run_imulab(folder, "budget m.toml --runs 0 --json").output);
  const double expected = budget["total"]["position_m"]["fixed"][0].get<double>();
  EXPECT_NEAR(Json::parse(r.output)["position_error"]["east_m"].get<double>(), expected, 1e-3 * expected);  // the linear model's blocks
}

TEST(BudgetCommand, AGivenUnitsRecordingNavigatesWithItsOwnCalibration) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure six-position --rest 2 -o p.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate p.toml -o s").exit_code, 0);  // for its truth
  folder.write("m.toml", motion);
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml --unit s/truth.json -o flight").exit_code, 0);
  const auto horizontal = [&](const std::string& calibration) {
    const CommandResult r = run_imulab(folder, "navigate " + calibration + " flight --vertical fixed --json");
    return r.exit_code == 0 ? Json::parse(r.output)["position_error"]["horizontal_m"].get<double>() : NAN;
  };
  EXPECT_LT(horizontal("s/truth.json"), 1e-2);  // 10 Hz; rounding of raw readings to the file's digits
  EXPECT_GT(horizontal("none"), 1);             // 70 ug of bias: 5 m
  EXPECT_EQ(run_imulab(folder, "trajectory m.toml --unit s/truth.json --errors -o both").exit_code, 2);
}

// Straight on with a receiver that is lost after 60 of 120 s: how long the mission does without it, in JSON, table and page; no Monte Carlo.
TEST(BudgetCommand, WithAidsItGrowsAfterTheirLoss) {
  const TemporaryFolder folder;
  folder.write(
      "m.toml",
      budget_mission(
          "vertical = \"held\"\naccel = { bias_ug = 1000, velocity_random_walk_ug_per_sqrt_hz = 100 }\n"
          "gyro = { bias_deg_per_h = 10, angle_random_walk_deg_per_sqrt_h = 1 }\nstart = { tilt_arcmin = 5, heading_arcmin = 60, velocity_mps = 1 }\n"
          "[[aid]]\nkind = \"gnss\"\noutages_s = [[60, 120]]\n"));
  const CommandResult r = run_imulab(folder, "budget m.toml --require \"RMS <= 20 m at 10 s, CEP <= 3 m\" --report page.html --json");
  EXPECT_EQ(r.exit_code, 1) << r.errors;
  EXPECT_THAT(on_one_line(r.errors), HasSubstr("vertical = \"held\""));
  const Json out = Json::parse(r.output);
  EXPECT_EQ(out["loss"], Json::parse(R"({"begin_s": 60.0, "aids": ["gnss"]})"));
  ASSERT_EQ(out["after_loss"].size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const Json& row = out["after_loss"][k];
    EXPECT_NEAR(row["seconds"].get<double>(), std::vector<double>({0, 10, 60})[k], 1e-9);
    double squares = 0;
    for (const auto& [source, size] : row["sources_m"].items()) squares += std::pow(size.get<double>(), 2);
    EXPECT_NEAR(std::sqrt(squares), row["horizontal_m"].get<double>(), 1e-6 * row["horizontal_m"].get<double>());
  }
  EXPECT_GT(out["after_loss"][2]["horizontal_m"], 5 * out["after_loss"][0]["horizontal_m"].get<double>());
  EXPECT_EQ(out["requirements"][0]["met"], true);
  EXPECT_THAT(out["requirements"][1]["note"].get<std::string>(), testing::ContainsRegex("within the limit for [0-9.]+ s after the loss"));
  folder.write("budget.json", r.output);
  ASSERT_EQ(run_imulab(folder, "report budget.json -o saved.html").exit_code, 0);
  for (const char* page : {"page.html", "saved.html"}) EXPECT_THAT(read_text(folder / page), HasSubstr("How long may gnss be away?")) << page;
  EXPECT_THAT(run_imulab(folder, "budget m.toml").output, HasSubstr("seconds after the loss            0       10       60\n"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "budget m.toml --runs 10").errors), HasSubstr("--runs: a mission with [[aid]] has no Monte Carlo"));
  EXPECT_THAT(run_imulab(folder, "budget m.toml --grade navigation,mems --require \"RMS <= 20 m\"").output, HasSubstr("RMS <= 20 m: for "));
  const std::string both = run_imulab(folder, "budget m.toml --grade navigation,mems --require \"RMS <= 1e-3 m\"").output;
  EXPECT_THAT(both, testing::StartsWith("doubtful: mems; not met: navigation; ")) << "the verdict once";
}

TEST(BudgetCommand, RefusesWhatIsWrong) {
  const TemporaryFolder folder;
  folder.write("plain.toml", motion);
  struct Case {
    std::string errors, message;
  };
  for (const Case& c : std::vector<Case>{
           {"grade = \"perfect\"\n", "grade = \"perfect\": unknown; expected one of strategic, navigation, tactical, mems, mems-30g"},
           {"system = \"LTN-72\"\n", "did you mean LTN-90?"},
           {"grade = \"navigation\"\nsystem = \"LTN-90\"\n", "expected at most one"},
           {"gyro = { bias_deg = 1 }\n", "m.toml:12: errors.gyro.bias_deg: is not a known key"},
           {"gyro = { bias_deg_per_h = -1 }\n", "errors.gyro.bias_deg_per_h: -1 is out of range"},
           {"gyro = { misalignment_arcsec = 1, nonorthogonality_arcsec = 1 }\n", "misalignment and nonorthogonality"},
           {"start = { aligned_over_s = 10, tilt_arcmin = 1 }\n", "errors.start.aligned_over_s"},
           {"start = { aligned_over_s = 1e12 }\n", "errors.start.aligned_over_s: 1000000000000"},
           {"vertical = \"up\"\n", "errors.vertical: \"up\" is not allowed; expected one of free, fixed, aided, held"},
           {"calibration = \"none.json\"\n", "none.json"},
           {"barometer = { noise_m = 1, time_constant_s = 0 }\n", "time_constant_s"},
       }) {
    folder.write("m.toml", budget_mission(c.errors));
    const CommandResult r = run_imulab(folder, "budget m.toml -o out");
    EXPECT_EQ(r.exit_code, 2) << c.errors << r.output;
    EXPECT_THAT(r.errors, HasSubstr(c.message)) << c.errors;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << c.errors;
  }
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"budget plain.toml", "no errors; expected [errors]"},
           {"budget", "--catalogue"},
           {"budget m.toml --every 0", "--every"},
           {"budget m.toml --runs -1", "--runs"},
           {"budget m.toml --grade navigation --system LTN-90", "excludes"},
           {"trajectory plain.toml --errors -o out", "expected an [errors] table"},
       }) {
    const CommandResult r = run_imulab(folder, arguments);
    EXPECT_EQ(r.exit_code, 2) << arguments;
    EXPECT_THAT(r.errors, HasSubstr(message)) << arguments;
  }
  EXPECT_THAT(run_imulab(folder, "budget --catalogue").output, HasSubstr("LTN-101"));
  EXPECT_EQ(run_imulab(folder, "budget plain.toml --grade navigation --runs 0").exit_code, 0);
}

}  // namespace
}  // namespace imulab
