// - is standard input or output wherever a stream makes sense: verbs compose.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

struct Pipe : ::testing::Test {
  TemporaryFolder folder;
  CommandResult shell(const std::string& command) const { return run_shell(folder, "imulab() { '" + command_path() + "' \"$@\"; }\n" + command); }
};

TEST_F(Pipe, AProcedureIsPredictedAndSimulated) {
  const CommandResult predicted = shell("imulab procedure zhang-24 | imulab predict - --runs 0");
  EXPECT_EQ(predicted.exit_code, 0) << predicted.errors;
  EXPECT_THAT(predicted.output, testing::HasSubstr("\ngyro.matrix.xy "));
  const CommandResult simulated = shell("imulab procedure hand-held --poses 20 | imulab simulate - -o session");
  EXPECT_EQ(simulated.exit_code, 0) << simulated.errors;
}

TEST_F(Pipe, ACalibrationIsExportedWithoutAFile) {
  ASSERT_EQ(shell("imulab procedure hand-held --poses 20 | imulab simulate - -o session").exit_code, 0);
  const CommandResult header = shell("imulab calibrate session --method handheld -o - | imulab export - --to c-header");
  EXPECT_EQ(header.exit_code, 0) << header.errors;
  EXPECT_THAT(header.output, testing::HasSubstr("static"));
}

TEST_F(Pipe, AResultThatCannotBePrintedIsAnError) {
  for (const char* verb : {"procedure hand-held", "budget --catalogue", "help calibrate", "--help", "noise --help", "--version"}) {
    const CommandResult result = shell(std::string("imulab ") + verb + " > /dev/full");
    EXPECT_EQ(result.exit_code, 2) << verb;
    EXPECT_THAT(result.errors, testing::HasSubstr("imulab: ")) << verb;
  }
}

TEST_F(Pipe, WhatIsWrongInAStreamIsNamed) {
  EXPECT_THAT(shell("echo 'format = 1' | imulab predict -").errors, testing::HasSubstr("imulab: standard input:1: format"));
  EXPECT_THAT(shell("echo '{' | imulab export - --to c-header").errors, testing::HasSubstr("imulab: standard input"));
  EXPECT_THAT(shell("printf 't,gx\\n0,1\\n' | imulab calibrate - --method handheld").errors, testing::HasSubstr("a recording has to be a file"));
  ASSERT_EQ(shell("imulab procedure hand-held --poses 12 | imulab simulate - -o session").exit_code, 0);
  EXPECT_THAT(shell("imulab export - --to euroc < session/truth.json").errors, testing::HasSubstr("imulab: standard input: the EuRoC form needs"));
}

TEST_F(Pipe, ASignalLeavesNothingHalfMade) {
  ASSERT_EQ(shell("imulab procedure zhang-24 --rest 3000 -o long.toml").exit_code, 0);
  for (const auto& [name, code] : {std::pair{"INT", 130}, std::pair{"TERM", 143}}) {
    // Seven million samples take seconds; the code tells that the signal came before their end.
    const CommandResult result = shell(std::string("timeout --preserve-status -s ") + name + " 0.7 '" + command_path() +
                                       "' simulate long.toml -o out; echo code $?; ls -d out*");
    EXPECT_EQ(result.output, "code " + std::to_string(code) + "\n") << "and nothing is left";
  }
  EXPECT_EQ(shell("imulab simulate long.toml -o out --seed -1").exit_code, 2);
}

TEST_F(Pipe, ALimitOnTheSizeOfFilesIsAnError) {
  ASSERT_EQ(shell("imulab procedure hand-held -o p.toml").exit_code, 0);
  const CommandResult result = shell("ulimit -f 10; imulab simulate p.toml -o out; echo code $?; ls -d out*");
  EXPECT_EQ(result.output, "code 2\n") << "and nothing is left";
  EXPECT_THAT(result.errors, testing::HasSubstr("recording.csv: cannot be written: File too large"));
}

}  // namespace
}  // namespace imulab
