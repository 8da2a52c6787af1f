// `imulab live` as a user types it: a stream from a pipe, and what becomes of it where it ends badly.
#include "imulab/formats/text/file.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <cmath>

namespace imulab {
namespace {

using ::testing::ContainsRegex;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Json = nlohmann::json;

/// A handheld session of 16 rests, simulated once; its steps say nothing to `live`.
const TemporaryFolder& folder() {
  static const TemporaryFolder made;
  static const bool simulated = [] {
    run_shell(made, "'" + command_path() + "' procedure handheld --poses 16 | sed 's/rate_hz = 100/rate_hz = 200/' > hand.toml");
    run_imulab(made, "simulate hand.toml -o session");
    run_shell(made, "sed '/^\\[\\[step\\]\\]/,$d' session/session.toml > session/found.toml");
    return true;
  }();
  (void)simulated;
  return made;
}

/// The recording through `filter` into `imulab live - --session session ARGUMENTS`.
CommandResult live(const std::string& filter, const std::string& arguments) {
  const std::string command = "'" + command_path() + "' live - --session session " + arguments;
  return run_shell(folder(), filter + " session/recording.csv | " + command);
}

std::vector<std::string> lines_with(const std::string& text, const std::string& part) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.find(part) != std::string::npos) found.push_back(line);
  return found;
}

TEST(Live, StopsWhereEverythingIsReached) {
  const CommandResult r = live("cat", "-o done.json");
  EXPECT_EQ(r.exit_code, 0) << r.errors;
  EXPECT_THAT(r.output, Not(HasSubstr("\033")));  // no terminal: lines
  EXPECT_THAT(r.output,
              ContainsRegex("rest 2: .* up\n.*reached: gyro.matrix.diagonal .*\n.*next: turn by [0-9]+ deg about .* points up, then hold still"));
  ASSERT_EQ(lines_with(r.output, "done: ").size(), 1u);
  const std::size_t rests = lines_with(r.output, "  rest ").size();
  EXPECT_GE(rests, 7u);
  EXPECT_LE(rests, 16u) << "and stops";
  EXPECT_EQ(lines_with(r.output, "  next: ").size(), rests - 1);
  EXPECT_THAT(r.output, ContainsRegex("[0-9]+ rests in [0-9]+ s: good; written: done.json\n$"));
  const Json c = Json::parse(read_text(folder() / "done.json"));
  EXPECT_EQ(c["method"], "handheld");
  for (const Json& requirement : c["quality"]["requirements"]) EXPECT_TRUE(requirement["met"]);
}

TEST(Live, AtTheEndSaysWhatIsMissingAndKeepsEverything) {
  const CommandResult r = live("cat", "-o ended.json --save session/saved.csv --require 'gyro.matrix.diagonal <= 10 ppm'");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.errors, ContainsRegex("imulab: not reached: gyro.matrix.diagonal [0-9.]+ ppm of 10 ppm\n  what helps most: turn by .* points up"));
  EXPECT_EQ(lines_with(r.output, "  rest ").size(), 16u);
  EXPECT_EQ(read_text(folder() / "session/saved.csv"), read_text(folder() / "session/recording.csv"));
  // They are the numbers from the file.
  run_shell(folder(), "sed -i 's/recording.csv/saved.csv/' session/found.toml");
  EXPECT_EQ(run_imulab(folder(), "calibrate session/found.toml --method handheld -o file.json").exit_code, 0);
  const Json streamed = Json::parse(read_text(folder() / "ended.json")), whole = Json::parse(read_text(folder() / "file.json"));
  EXPECT_EQ(streamed["model"], whole["model"]);
  EXPECT_EQ(streamed["covariance"], whole["covariance"]);
  EXPECT_EQ(streamed["sources"][0]["sha256"], whole["sources"][0]["sha256"]);
}

TEST(Live, EndsWhereTheMemoryDoes) {
  const CommandResult r = live("cat", "-o half.json --require 'gyro.matrix.diagonal <= 10 ppm' --memory 2");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(r.errors,
              ContainsRegex("imulab: a calibration while [0-9]+ s arrive takes about 0.0020[0-9]* GB of memory; expected at most 0.002 GB"));
  const std::size_t rests = lines_with(r.output, "  rest ").size();
  EXPECT_GE(rests, 4u);
  EXPECT_LT(rests, 16u);
  EXPECT_TRUE(std::filesystem::exists(folder() / "half.json")) << "what came so far is not lost";
  EXPECT_THAT(r.output, ContainsRegex("[0-9]+ rests in [0-9]+ s: .*; written: half.json\n$"));
}

TEST(Live, TheCalibrationAloneGoesToStandardOutput) {
  const CommandResult r = live("cat", "-o -");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(Json::parse(r.output)["method"], "handheld");
  EXPECT_THAT(r.errors, ContainsRegex("done: .*\n.*written: standard output\n"));
}

TEST(Live, FilesAreNotReplacedByAccident) {
  run_shell(folder(), "echo > there.csv");
  for (const char* arguments : {"-o there.csv", "--save there.csv"}) {
    const CommandResult r = live("cat", arguments);
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_THAT(r.errors, HasSubstr("there.csv: exists; expected a new file, or --force"));
  }
  EXPECT_THAT(live("cat", "--force --save session/recording.csv").errors, HasSubstr("would overwrite session/recording.csv"));
}

TEST(Live, BadStreams) {
  const char* const require = "--force -o bad.json --save bad.csv --require 'gyro.matrix.diagonal <= 1 ppm'";
  struct Case {
    const char *filter, *says;
    int exit_code;
    bool written;
  };
  for (const Case& c : {
           Case{"head -c 1000000", "the last line has no end and was not used\n", 1, true},
           {"awk -F, -v OFS=, 'NR == 9000 {$4 = \"nan\"} 1'",
            "1 line left out (nothing is measured there), the first line 9000: gz: nan is not a reading", 1, true},
           {"awk -F, -v OFS=, 'NR == 9000 {$1 -= 3} 1'", "standard input:9000: t: time runs backwards", 2, true},
           {"awk 'NR < 6600 || NR > 7000'", "1 gap in time, the first before 35.000 s", 1, true},
           {"awk -F, -v OFS=, 'NR > 1 {for (i = 2; i <= 7; i++) $i = 5 * sin($1 * (3 + i / 7) + i)} 1'", "no rests", 1, false},
           {"head -1", "has a header but no rows", 2, false},
           {"head -2", "fewer than two rows arrived", 1, false},
           {"head -0", "standard input: is empty", 2, false},
       }) {
    SCOPED_TRACE(c.filter);
    std::filesystem::remove(folder() / "bad.json");
    const CommandResult r = live(c.filter, require);
    EXPECT_EQ(r.exit_code, c.exit_code) << r.errors;
    EXPECT_THAT(r.errors, HasSubstr(c.says));
    EXPECT_EQ(std::filesystem::exists(folder() / "bad.json"), c.written);
    const std::string came = run_shell(folder(), std::string(c.filter) + " session/recording.csv").output, saved = read_text(folder() / "bad.csv");
    EXPECT_TRUE(came.starts_with(saved)) << "as it came";
    EXPECT_GE(saved.size(), c.exit_code == 2 && c.written ? 1000000u : came.size()) << "up to the row that ends it";
  }
}

TEST(Live, CtrlCEndsTheStreamAsIfTheLastRowHadCome) {
  const CommandResult r =
      run_shell(folder(), std::string("mkfifo rows; (head -20000 session/recording.csv; sleep 20) > rows & '") + command_path() +
                              "' live - --session session -o stopped.json --require 'gyro.matrix.diagonal <= 10 ppm' < rows > log & p=$!\n"
                              "for i in $(seq 100); do grep -q 'rest 10' log && break; sleep 0.1; done; kill -INT $p; wait $p");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.errors, HasSubstr("stopped by Ctrl-C"));
  EXPECT_THAT(r.errors, HasSubstr("not reached: gyro.matrix.diagonal"));
  EXPECT_TRUE(std::filesystem::exists(folder() / "stopped.json"));
}

TEST(Live, RefusesWhatCannotBeReached) {
  const CommandResult r = live("cat", "--require 'accel.matrix.diagonal <= 10 ppm'");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.errors, HasSubstr("accel.matrix.xx cannot be better than gravity, 30.6 ppm"));
}

TEST(Live, CalibrateNamesTheTurnsThatAreMissing) {
  run_shell(folder(),
            "head -12000 session/recording.csv > session/short.csv; sed -e 's/recording.csv/short.csv/' -e '/^\\[\\[step\\]\\]/,$d' "
            "session/session.toml > session/short.toml");
  const CommandResult r = run_imulab(folder(), "calibrate session/short.toml --method handheld");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.errors,
              ContainsRegex("the data do not determine: .*; they keep their starting values\n  what helps most: turn by .* points up, hold still"));
}

}  // namespace
}  // namespace imulab
