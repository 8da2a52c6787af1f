// The command explains itself: in 80 columns, with examples that its own parser accepts, in manual pages and in shells.

// ctest: once
#include "imulab/version.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <vector>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::vector<std::string> verbs{"calibrate",
                                     "inspect",
                                     "live",
                                     "noise",
                                     "compare",
                                     "verify",
                                     "report",
                                     "procedure",
                                     "procedure handheld",
                                     "procedure dai-unit",
                                     "simulate",
                                     "predict",
                                     "plan",
                                     "compensate",
                                     "export",
                                     "import",
                                     "trajectory",
                                     "navigate",
                                     "budget",
                                     "demo",
                                     "help",
                                     "fleet",
                                     "fleet add",
                                     "fleet calibrate",
                                     "fleet list",
                                     "fleet show",
                                     "fleet stats",
                                     "fleet check",
                                     "fleet merge",
                                     "fleet export",
                                     "fleet remove"};

TEST(Help, FitsATerminal) {
  const TemporaryFolder folder;
  for (const std::string& verb : verbs) {
    const CommandResult result = run_imulab(folder, verb + " --help");
    EXPECT_EQ(result.exit_code, 0) << verb;
    EXPECT_EQ(result.output, run_imulab(folder, "help " + verb).output);
    std::istringstream lines(result.output);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST(Help, ListsEveryVerbInAGroup) {
  const TemporaryFolder folder;
  const std::string text = run_imulab(folder, "--help").output;
  for (const char* group : {"\nstart here\n", "\ncalibrate\n", "\nbefore the measurement\n", "\nuse a calibration\n", "\nin navigation\n"})
    EXPECT_THAT(text, HasSubstr(group));
  for (const std::string& verb : verbs)
    if (verb.find(' ') == std::string::npos) {
      EXPECT_THAT(text, HasSubstr("\n  " + verb + " ")) << verb;
    }
}

TEST(Help, TheVersionSaysWhatImulabWasBuiltWith) {
  const TemporaryFolder folder;
  const std::string text = run_imulab(folder, "--version").output;
  const Build b = build();
  EXPECT_THAT(text, StartsWith("imulab " + b.version + "\ncompiler  " + b.compiler + ", "));
  for (const BuildOption& option : b.options)
    EXPECT_THAT(text, ContainsRegex("\n" + std::string(option.built_with ? "with" : "without") + " +" + option.name + " +" + option.purpose + "\n"));
}

/// An example that the parser refuses has a wrong name in it; files that do not exist are refused later.
TEST(Help, EachVerbHasAnExampleThatItsParserAccepts) {
  const TemporaryFolder folder;
  for (const std::string& verb : verbs) {
    if (verb == "procedure" || verb == "demo" || verb == "help") {  // of a verb of theirs, too slow, of a verb
      EXPECT_THAT(run_imulab(folder, "help " + verb).output, ContainsRegex("\nexamples?\n  imulab " + verb + " [a-z-]+")) << verb;
      continue;
    }
    const std::string text = run_imulab(folder, "help " + verb).output;
    const std::size_t at = text.find("imulab " + verb + " ", text.find("\nexample"));
    ASSERT_NE(at, std::string::npos) << verb;
    const std::string example = text.substr(at + 7, text.find('\n', at) - at - 7);
    EXPECT_THAT(run_imulab(folder, example).errors, Not(HasSubstr("--help explains"))) << example;
  }
}

TEST(Help, WritesManualPages) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "help --man man").exit_code, 0);
  EXPECT_THAT(read_text(folder / "man/imulab.1"), HasSubstr(".B calibrate\n"));
  const std::string page = read_text(folder / "man/imulab-calibrate.1");
  EXPECT_THAT(page, HasSubstr(".TH IMULAB-CALIBRATE 1 "));
  EXPECT_THAT(page, HasSubstr("\\-o, \\-\\-output FILE"));
  EXPECT_THAT(page, HasSubstr(".SH EXAMPLES\n"));
  EXPECT_THAT(read_text(folder / "man/imulab-fleet-stats.1"), HasSubstr("\\-\\-due LIMITS"));
}

TEST(Help, BashCompletesVerbsOptionsAndValues) {
  const TemporaryFolder folder;
  const auto completed = [&](const std::string& words) {
    return run_shell(folder, "cat > complete.sh <<'END'\nsource <('" + command_path() + "' help --completion bash)\nCOMP_WORDS=(" + words +
                                 ")\nCOMP_CWORD=$((${#COMP_WORDS[@]}-1))\n_imulab\necho \"${COMPREPLY[@]}\"\nEND\nbash complete.sh")
        .output;
  };
  EXPECT_EQ(completed("imulab calib"), "calibrate\n");
  EXPECT_EQ(completed("imulab calibrate --met"), "--method\n");
  EXPECT_EQ(completed("imulab calibrate session --method hy"), "hybrid\n");
  EXPECT_EQ(completed("imulab procedure zh"), "zhang-24\n");
  EXPECT_EQ(completed("imulab procedure zhang-24 --re"), "--rest\n");
}

TEST(Help, WithoutACommandItIsShown) {
  const TemporaryFolder folder;
  const CommandResult result = run_imulab(folder, "");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("usage: imulab COMMAND"));
}

TEST(Help, ThreadsAreTakenByEveryVerb) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_imulab(folder, "procedure handheld --poses 12 -o h.toml --threads 1").exit_code, 0);
  EXPECT_THAT(run_imulab(folder, "procedure handheld --threads 0").errors, HasSubstr("--threads"));
}

}  // namespace
}  // namespace imulab
