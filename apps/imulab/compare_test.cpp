#include "imulab/core/units.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/model/coefficient.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <cmath>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

/// The accelerometers' offsets to 10 ug and one gyro element to 2 arcsec.
Calibration any_calibration() {
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
    folder.write("calibration.json", calibration_text(any_calibration()));
    folder.write("truth.json", calibration_text(truth()));
  }
};

TEST_F(CompareCommand, PrintsATableInUserUnitsAndMarksWhatDiffers) {
  const CommandResult result = run_imulab(folder, "compare calibration.json truth.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, ContainsRegex("accel.offset.x .* 5 +10 ug +\\+0.5\n"));
  EXPECT_THAT(result.output, ContainsRegex("gyro.matrix.xy .* 20 +2 arcsec +\\+10.0 \\*\n"));
  EXPECT_THAT(result.output, HasSubstr("1 of 2 coefficients differ significantly"));
  EXPECT_THAT(result.output, HasSubstr("2 coefficients together: chi2 = 100.2"));  // 0.5^2 + 10^2
  EXPECT_THAT(result.output, HasSubstr("quadratic and cubic terms are compared unrotated"));
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

TEST_F(CompareCommand, SeveralAreComparedWithTheFirst) {
  const CommandResult table = run_imulab(folder, "compare calibration.json truth.json calibration.json");
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_THAT(table.output, HasSubstr("B  truth.json"));
  EXPECT_THAT(table.output, HasSubstr("B  calibration.json"));
  const auto json = nlohmann::json::parse(run_imulab(folder, "compare calibration.json truth.json calibration.json --json").output);
  ASSERT_EQ(json["comparisons"].size(), 2u);
  EXPECT_EQ(json["comparisons"][1]["b"], "calibration.json");
  EXPECT_EQ(json["comparisons"][1]["coefficients"]["gyro.matrix.xy"]["difference"], 0);
}

TEST_F(CompareCommand, TwoTruthsHaveNothingToTest) {
  const CommandResult result = run_imulab(folder, "compare truth.json truth.json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("nothing to test"));
}

TEST_F(CompareCommand, WrongUseIsExplained) {
  folder.write("newer.json", "{\"format\": \"imulab.calibration/2\"}");
  struct Case {
    const char *arguments, *message;
  };
  for (const Case& c : {Case{"calibration.json", "required"}, Case{"calibration.json absent.json", "imulab: absent.json: "},
                        Case{"newer.json calibration.json",
                             "imulab: newer.json: format: imulab.calibration/2 is a newer format; this program reads imulab.calibration/1"}}) {
    const CommandResult result = run_imulab(folder, std::string("compare ") + c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments;
    EXPECT_THAT(result.errors, HasSubstr(c.message)) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
  }
}

}  // namespace
}  // namespace imulab
