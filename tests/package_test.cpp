// The installed package serves a project of its own.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

TEST(Package, AnotherProjectFindsLinksAndUsesIt) {
  const TemporaryFolder folder;
  const std::string build = std::filesystem::path(IMULAB_COMMAND).parent_path().string();
  const auto expect_done = [&](const std::string& command) {
    const CommandResult result = run_shell(folder, command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.output << result.errors;
    return result.output;
  };
  expect_done("cmake --install '" + build + "' --prefix \"$PWD/prefix\"");
  ASSERT_FALSE(HasFailure());
  EXPECT_THAT(expect_done("prefix/bin/imulab --version"), ::testing::StartsWith("imulab "));
  expect_done("cmake -S '" IMULAB_SOURCE "/tests/consumer' -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=\"$PWD/prefix\"");
  ASSERT_FALSE(HasFailure());
  expect_done("cmake --build build");
  ASSERT_FALSE(HasFailure());
  EXPECT_EQ(expect_done("build/consumer"), "1 1 16 11 22 33\n");
}

}  // namespace
}  // namespace imulab
