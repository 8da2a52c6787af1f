// The demo runs from nothing, twice over its own files, and leaves what is not its own.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <algorithm>

namespace imulab {
namespace {

TEST(DemoCommand, RunsFromNothingAndAgain) {  // ctest: once
  const TemporaryFolder folder;
  const CommandResult first = run_imulab(folder, "demo -o d");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_LE(std::count(first.output.begin(), first.output.end(), '\n'), 15);
  EXPECT_THAT(first.output, testing::HasSubstr("An hour's drive, 20 times"));
  EXPECT_THAT(first.output, testing::HasSubstr("Your own sensor: " + command_path() + " calibrate FOLDER")) << "as it was started";
  folder.write("d/mine.txt", "kept");
  const CommandResult again = run_imulab(folder, "demo -o d");
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(read_text(folder / "d" / "mine.txt"), "kept");
  EXPECT_EQ(again.output, first.output);
}

/// The claim of the demo is true of other units than the default one.
TEST(DemoCommand, TheHybridCalibrationDrivesBetterWithOtherSeeds) {  // ctest: long
  const TemporaryFolder folder;
  for (const char* seed : {"2", "3"}) {
    const CommandResult result = run_imulab(folder, std::string("demo --json --seed ") + seed);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    const auto json = nlohmann::json::parse(result.output);
    EXPECT_LT(json["hybrid [m]"], json["classical [m]"]) << seed;
  }
}

}  // namespace
}  // namespace imulab
