// calibrate --method hybrid as people use it.
// ctest: once
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <sstream>

namespace imulab {
namespace {

using ::testing::HasSubstr;

TEST(CalibrateHybrid, WritesChengsTableAndHisCurves) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure cheng-path --rest 10 -o path.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate path.toml -o session").exit_code, 0);
  const CommandResult result = run_imulab(folder, "calibrate session --method hybrid -o c.json --curves curves.csv --verbose");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("coarse   correction         value"));
  EXPECT_THAT(result.output, HasSubstr("iterations over"));
  EXPECT_THAT(result.output, testing::StartsWith("good: "));
  EXPECT_EQ(run_imulab(folder, "compare c.json session/truth.json").exit_code, 0);

  std::istringstream curves(read_text(folder / "curves.csv"));
  std::string line, last;
  std::getline(curves, line);
  EXPECT_THAT(line, HasSubstr("t,accel.offset.x,accel.offset.x.sigma,"));
  const auto columns = std::count(line.begin(), line.end(), ',');
  EXPECT_EQ(columns, 84);  // 21 coefficients and 21 of optional terms, each with its sigma
  int points = 0;
  for (; std::getline(curves, line); ++points) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
  EXPECT_GT(points, 300);
  EXPECT_LT(points, 600);
}

TEST(CalibrateHybrid, AScaleFarFromTheDeclaredUnitIsKeptButEndsWithItsFactor) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "procedure cheng-path --rest 10 -o path.toml").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "simulate path.toml -o session").exit_code, 0);
  ASSERT_EQ(run_shell(folder,
                      "awk -F, -v OFS=, -v CONVFMT=%.12g 'NR > 1 {$5 *= 0.7; $6 *= 0.7; $7 *= 0.7} {print}' session/recording.csv > seven.csv; "
                      "mv seven.csv session/recording.csv")
                .exit_code,
            0);
  const CommandResult result = run_imulab(folder, "calibrate session --method hybrid -o hybrid.json");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("imulab: the accelerometers' scale is 1.4"));
  EXPECT_TRUE(std::filesystem::exists(folder / "hybrid.json"));
}

TEST(CalibrateHybrid, OtherMethodsHaveNoCurves) {
  const TemporaryFolder folder;
  const CommandResult result = run_imulab(folder, "calibrate session --method static --curves curves.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("--curves: only the method hybrid, reference has curves over time"));
}

}  // namespace
}  // namespace imulab
