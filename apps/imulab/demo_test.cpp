// The demo runs from nothing, twice over its own files, and leaves what is not its own.
#include "tests/run_command.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

TEST(DemoCommand, RunsFromNothingAndAgain) {
  const TemporaryFolder folder;
  const CommandResult first = run_imulab(folder, "demo -o d");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_THAT(first.output, testing::HasSubstr("0 of 51 coefficients differ significantly"));
  EXPECT_THAT(first.output, testing::HasSubstr("and with the hybrid one:"));
  folder.write("d/path/mine.txt", "kept");
  const CommandResult blocked = run_imulab(folder, "demo -o d");
  EXPECT_EQ(blocked.exit_code, 2);  // a folder that holds something of somebody else's
  EXPECT_EQ(read_text(folder / "d" / "path" / "mine.txt"), "kept");
  std::filesystem::remove(folder / "d" / "path" / "mine.txt");
  const CommandResult again = run_imulab(folder, "demo -o d");
  EXPECT_EQ(again.exit_code, 0) << again.errors;
}

}  // namespace
}  // namespace imulab
