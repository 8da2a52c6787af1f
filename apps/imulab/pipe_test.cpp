// - is standard input or output wherever a stream makes sense: verbs compose.
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include "tests/run_command.hpp"
#include <sstream>

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
  const CommandResult simulated = shell("imulab procedure handheld --poses 20 | imulab simulate - -o session");
  EXPECT_EQ(simulated.exit_code, 0) << simulated.errors;
}

TEST_F(Pipe, ACalibrationIsExportedWithoutAFile) {
  ASSERT_EQ(shell("imulab procedure handheld --poses 20 | imulab simulate - -o session").exit_code, 0);
  const CommandResult header = shell("imulab calibrate session --method handheld -o - | imulab export - --to c-header");
  EXPECT_EQ(header.exit_code, 0) << header.errors;
  EXPECT_THAT(header.output, testing::HasSubstr("static"));
}

TEST_F(Pipe, AResultThatCannotBePrintedIsAnError) {
  for (const char* verb : {"procedure handheld", "budget --catalogue", "help calibrate", "--help", "noise --help", "--version"}) {
    const CommandResult result = shell(std::string("imulab ") + verb + " > /dev/full");
    EXPECT_EQ(result.exit_code, 2) << verb;
    EXPECT_THAT(result.errors, testing::HasSubstr("imulab: ")) << verb;
  }
}

TEST_F(Pipe, WhereNobodyHearsAnErrorTheExitCodeSaysIt) {
  EXPECT_EQ(shell("imulab predict nowhere 2>&-").exit_code, 2);
  EXPECT_EQ(shell("imulab predict nowhere 2>/dev/full").exit_code, 2);
}

TEST_F(Pipe, WhatIsWrongInAStreamIsNamed) {
  EXPECT_THAT(shell("echo 'format = 1' | imulab predict -").errors, testing::HasSubstr("imulab: standard input:1: format"));
  EXPECT_THAT(shell("echo '{' | imulab export - --to c-header").errors, testing::HasSubstr("imulab: standard input"));
  EXPECT_THAT(shell("printf 't,gx\\n0,1\\n' | imulab calibrate - --method handheld").errors, testing::HasSubstr("imulab: standard input: "));
  ASSERT_EQ(shell("imulab procedure handheld --poses 12 | imulab simulate - -o session").exit_code, 0);
  EXPECT_THAT(shell("imulab export - --to euroc < session/truth.json").errors, testing::HasSubstr("imulab: standard input: the EuRoC form needs"));
}

/// The JSON without the name of the input, the time of the run, and the names derived from it.
std::string without_names(const std::string& json) {
  std::istringstream lines(json);
  std::string kept;
  for (std::string line; std::getline(lines, line);)
    if (line.find("log") == std::string::npos && line.find("standard input") == std::string::npos && line.find("\"created\"") == std::string::npos)
      kept += line + '\n';
  return kept;
}

TEST_F(Pipe, RowsAreWhatTheirFileIs) {
  hand_held_session().write(folder);
  ASSERT_EQ(shell("cp session/recording.csv log.csv").exit_code, 0);
  const CommandResult file = shell("imulab calibrate log.csv --method handheld --json");
  const CommandResult rows = shell("cat log.csv | imulab calibrate - --method handheld --json");
  ASSERT_EQ(rows.exit_code, 0) << rows.errors;
  EXPECT_EQ(without_names(rows.output), without_names(file.output));
  EXPECT_GT(without_names(rows.output).size(), 10'000U);
  EXPECT_THAT(rows.errors, testing::HasSubstr("imulab: assumed: 100 Hz; gyro gx, gy, gz in rad/s; accel ax, ay, az in m/s^2"));
  EXPECT_EQ(rows.errors, file.errors) << "the same is assumed";
  EXPECT_THAT(shell("cat log.csv | imulab calibrate - --method handheld --set gyro.unit=deg/s").errors,
              testing::HasSubstr("imulab: standard input: the gyros' scale is 58.86 in the declared unit"));
  const CommandResult session = shell("cd session; cat session.toml | imulab calibrate - --method handheld");
  EXPECT_EQ(session.exit_code, 0) << session.errors << "names its recording";
  EXPECT_THAT(shell("cat session/session.toml | imulab calibrate - --method handheld --set rate_hz=100").errors,
              testing::HasSubstr("--set: declares a recording"));
}

TEST_F(Pipe, ALogAtRestIsWhatItsFileIs) {
  ASSERT_EQ(shell("awk 'BEGIN { srand(7); print \"t,gx,gy,gz,ax,ay,az\"; for (i = 0; i < 6000; ++i) { printf \"%.2f\", i / 100; "
                  "for (k = 0; k < 6; ++k) { s = 0; for (j = 0; j < 12; ++j) s += rand() - 0.5; "
                  "printf \",%.6f\", (k < 3 ? 1e-3 : 1e-2) * s + (k == 5 ? 9.81 : 0) } print \"\" } }' > log.csv")
                .exit_code,
            0);
  const CommandResult file = shell("imulab noise log.csv --set gyro.unit=rad/s --json"),
                      rows = shell("cat log.csv | imulab noise - --set gyro.unit=rad/s --json");
  ASSERT_EQ(rows.exit_code, 0) << rows.errors;
  EXPECT_EQ(without_names(rows.output), without_names(file.output));
  EXPECT_GT(without_names(rows.output).size(), 1'000U);
  EXPECT_THAT(shell("imulab noise - - < log.csv").errors, testing::HasSubstr("imulab: -: standard input is named twice; expected it once"));
  EXPECT_EQ(shell("imulab noise - log.csv --set gyro.unit=rad/s < log.csv").exit_code, 0) << "of several logs one";
}

TEST_F(Pipe, WhatIsNeitherASessionNorRowsIsNamed) {
  EXPECT_THAT(shell("imulab noise - < /dev/null").errors, testing::HasSubstr("standard input: is empty; expected a session, or rows of a recording"));
  const CommandResult no_text = shell("printf '\\223NUMPY\\001\\000' | imulab noise -");
  EXPECT_EQ(no_text.exit_code, 2);
  EXPECT_THAT(no_text.errors, testing::HasSubstr("standard input: is NumPy"));
  EXPECT_THAT(no_text.errors, testing::HasSubstr("expected rows of text, or a file on disk"));
  // A comment that mentions a session does not make one of rows, and blanks without an end do no harm.
  EXPECT_THAT(shell("printf '# format = \"imulab.session/1\"\\n1 2 3\\n' | imulab noise -").errors, testing::Not(testing::HasSubstr("key")));
  EXPECT_EQ(shell("(printf '\\nformat'; head -c 1000000 /dev/zero | tr '\\0' ' ') | imulab noise -").exit_code, 2);
}

TEST_F(Pipe, EveryVerbReadsItsFileFromStandardInput) {
  hand_held_session().write(folder);
  ASSERT_EQ(shell("imulab calibrate session --method handheld -o c.json").exit_code, 0);
  ASSERT_EQ(shell("imulab calibrate session --method handheld --json > result.json").exit_code, 0);
  folder.write("mission.toml", "");
  for (const std::string verb :
       {"compare - c.json", "compare c.json -", "verify -", "report - -o page.html", "export - --to c-header", "fleet add - --store f.db"}) {
    const CommandResult result = shell("imulab " + verb + " < c.json");
    EXPECT_EQ(result.exit_code, 0) << verb << ": " << result.errors;
  }
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
  ASSERT_EQ(shell("imulab procedure handheld -o p.toml").exit_code, 0);
  const CommandResult result = shell("ulimit -f 10; imulab simulate p.toml -o out; echo code $?; ls -d out*");
  EXPECT_EQ(result.output, "code 2\n") << "and nothing is left";
  EXPECT_THAT(result.errors, testing::HasSubstr("recording.csv: cannot be written: File too large"));
}

}  // namespace
}  // namespace imulab
