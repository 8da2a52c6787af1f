// imulab noise --moving: logs, data sheets and results after it, and what it refuses.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/still_log.hpp"
#include <algorithm>
#include <cmath>
#include <sstream>

namespace imulab {
namespace {

using ::testing::HasSubstr;

/// The noise of still_readings with a sine of 31.8 Hz, which aliasing does not change, in the gyros and accelerometers.
std::array<double, 6> with_motors(int i) {
  std::array<double, 6> row = still_readings(i + 100000);
  for (std::size_t k = 0; k < 6; ++k) row[k] += (k < 3 ? 3e-3 : 0.03) * std::sin(2.0 * i);
  return row;
}

/// quiet.toml and idle.toml, each with its log.
void write_both(const TemporaryFolder& folder) {
  for (const auto& [name, samples, row] : {std::tuple("idle", 9000, ReadingsAt(with_motors)), {"quiet", 20000, ReadingsAt(still_readings)}}) {
    write_still_log(folder, samples, row);
    std::string session = read_text(folder / "session.toml");
    session.replace(session.find("log.csv"), 7, std::string(name) + ".csv");
    folder.write(std::string(name) + ".csv", read_text(folder / "log.csv")), folder.write(std::string(name) + ".toml", session);
  }
}

std::size_t longest_line(const std::string& text) {
  std::istringstream in(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(in, line);) longest = std::max(longest, line.size());
  return longest;
}

TEST(NoiseMovingCommand, TellsWhereTheFactorComesFrom) {
  const TemporaryFolder folder;
  write_both(folder);
  const CommandResult result = run_imulab(folder, "noise quiet.toml --moving idle.toml -o noise.json --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  // sqrt(1 + A^2 / 2 / (sigma^2)) with sigma = 1e-3 / sqrt(3), A = 3e-3, and the same ratio of the accelerometers: 3.81.
  EXPECT_THAT(on_one_line(result.output), testing::ContainsRegex("gyro.* vibration 3\\.[89]: use N 0\\.7[0-9]* deg/sqrt\\(h\\)"));
  EXPECT_THAT(result.output, testing::ContainsRegex("vibration +3\\.[78][0-9]* [xyz] +3\\.[0-9]+ to 3\\.[0-9]+ "));
  EXPECT_THAT(on_one_line(result.output), HasSubstr("most at 31.8 Hz"));
  EXPECT_LE(longest_line(result.output), 80u);
  const nlohmann::json json = nlohmann::json::parse(read_text(folder / "noise.json"));
  EXPECT_NEAR(json.at("moving").at("axes").at(5).at("N").at("factor").get<double>(), 3.81, 0.1);
  EXPECT_THAT(read_text(folder / "page.html"), HasSubstr("Where the factor comes from"));
  ASSERT_EQ(run_imulab(folder, "report noise.json -o saved.html").exit_code, 0);
  EXPECT_THAT(read_text(folder / "saved.html"), HasSubstr("Where the factor comes from"));
  const CommandResult exported = run_imulab(folder, "export none --noise noise.json --to vins");
  EXPECT_THAT(on_one_line(exported.output), HasSubstr("the factors of motion that noise.json also contains are NOT in them"));
  const CommandResult again = run_imulab(folder, "noise noise.json --moving idle.toml --json");
  EXPECT_EQ(nlohmann::json::parse(again.output).at("moving"), json.at("moving")) << "the file has what the log has";
}

TEST(NoiseMovingCommand, ABoundIsAboveBothLogs) {
  const TemporaryFolder folder;
  write_both(folder);
  const CommandResult both = run_imulab(folder, "noise quiet.toml --bound --horizon 10 --moving idle.toml -o both.json");
  ASSERT_EQ(both.exit_code, 0) << both.errors;
  EXPECT_THAT(on_one_line(both.output), HasSubstr("what the logs at rest and in motion permit with 95 %"));
  const nlohmann::json json = nlohmann::json::parse(read_text(folder / "both.json"));
  for (const auto& axis : json.at("axes")) EXPECT_EQ(axis.at("bound").at("in_motion"), true) << axis.at("name");
  const CommandResult exported = run_imulab(folder, "export none --noise both.json --bound --to kf-gins");
  EXPECT_THAT(on_one_line(exported.output),
              testing::AllOf(HasSubstr("what the logs at rest and in motion permit"), testing::Not(HasSubstr("NOT in them"))));
  // What is declared is of the log that is no session.
  EXPECT_EQ(run_imulab(folder, "noise quiet.toml --moving idle.csv --set gyro.unit=rad/s").exit_code, 0);
  // The saved bound of the log at rest gives the same.
  ASSERT_EQ(run_imulab(folder, "noise quiet.toml --bound --horizon 10 -o rest.json").exit_code, 0);
  const CommandResult later = run_imulab(folder, "noise rest.json --moving idle.toml --json");
  EXPECT_EQ(nlohmann::json::parse(later.output).at("axes")[0].at("bound"), json.at("axes")[0].at("bound"));
}

TEST(NoiseMovingCommand, TakesDataSheetsAndResults) {
  const TemporaryFolder folder;
  write_both(folder);
  const CommandResult sheet = run_imulab(folder, "noise --datasheet 'gyro.N = 0.1985 deg/sqrt(h), accel.N = 58.9 ug/sqrt(Hz)' --moving idle.toml");
  EXPECT_EQ(sheet.exit_code, 0) << sheet.errors;
  EXPECT_THAT(sheet.output, testing::ContainsRegex("vibration +3\\.[789]"));
  EXPECT_THAT(on_one_line(sheet.output), HasSubstr("the noise at rest has no mean readings"));
  for (const char* words : {"procedure handheld -o hand.toml", "simulate hand.toml -o hand", "calibrate hand --method handheld -o c.json"})
    ASSERT_EQ(run_imulab(folder, words).exit_code, 0) << words;
  const CommandResult both = run_imulab(folder, "noise quiet.toml --moving idle.toml c.json");
  EXPECT_EQ(both.exit_code, 0) << both.errors;
  EXPECT_THAT(both.output, testing::ContainsRegex("motion +[0-9.]+ x +[0-9.]+ to [0-9.]+ "));
}

TEST(NoiseMovingCommand, RefusesWhatItCannotCompare) {
  const TemporaryFolder folder;
  write_both(folder);
  write_still_log(folder, 6000, [](int i) {
    std::array<double, 6> row = still_readings(i);
    for (std::size_t k = 0; k < 6; ++k) row[k] += (1 + 0.5 * std::sin(0.0137 * i)) * std::sin(0.05 * i + static_cast<double>(k));
    return row;
  });
  ASSERT_EQ(run_imulab(folder, "noise quiet.toml -o noise.json").exit_code, 0);
  struct Refusal {
    const char *words, *message;
    int exit_code;
  };
  for (const auto& [words, message, code] :
       {Refusal{"noise idle.toml --moving quiet.toml", "expected the log at rest first: imulab noise quiet.toml --moving", 1},
        Refusal{"noise session.toml --moving quiet.toml", "before --moving, expected the log at rest", 1},
        Refusal{"noise quiet.toml --moving noise.json", "expected a log, calibration.json, or what imulab navigate --aided --json prints", 2},
        Refusal{"noise quiet.toml quiet.toml --moving idle.toml", "--moving: is compared with one log at rest", 2},
        Refusal{"noise noise.json --bound --moving idle.toml", "--bound: analyzes a log, and none is given", 2},
        Refusal{"noise noise.json --model N,B,K --moving idle.toml", "--model: analyzes a log, and none is given", 2},
        Refusal{"noise noise.json --horizon 60 --moving idle.toml", "--horizon: is of a bound", 2},
        Refusal{"noise quiet.toml --moving none.csv", "none.csv", 2}}) {
    const CommandResult result = run_imulab(folder, words);
    EXPECT_EQ(result.exit_code, code) << words;
    EXPECT_THAT(on_one_line(result.errors), HasSubstr(message)) << words;
  }
}

}  // namespace
}  // namespace imulab
