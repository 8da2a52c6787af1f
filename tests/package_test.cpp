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
  expect_done("prefix/bin/imulab procedure hand-held --poses 12 -o hand.toml && prefix/bin/imulab simulate hand.toml -o session");
  const std::string output = expect_done("build/consumer session");
  EXPECT_THAT(output, ::testing::HasSubstr("verdict: good\n9600 samples; the last: "));
  EXPECT_THAT(expect_done("prefix/bin/imulab compare calibration.json session/truth.json"),
              ::testing::HasSubstr("0 of 30 coefficients differ significantly"));
  EXPECT_NE(run_shell(folder, "build/consumer nowhere").exit_code, 0);
}

TEST(Package, TheTutorialShowsThatVeryProject) {
  const std::string page = read_text(IMULAB_SOURCE "/docs/tutorial-library.md");
  for (const char* file : {"main.cpp", "CMakeLists.txt"}) {
    const std::string text = read_text(std::filesystem::path(IMULAB_SOURCE) / "tests/consumer" / file);
    ASSERT_NE(text, "") << file;
    EXPECT_THAT(page, ::testing::HasSubstr("\n" + text + "```\n")) << file;
  }
}

}  // namespace
}  // namespace imulab
