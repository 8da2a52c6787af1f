// imulab report of what each verb prints with --json, as the manual's table has it.
// ctest: once
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <cctype>
#include <map>
#include <set>
#include <sstream>
#include <string>

namespace imulab {
namespace {

/// A recording of a minute at rest.
void simulate_rest(const TemporaryFolder& folder, const std::string& name) {
  folder.write(name + ".toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"still\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 47.0\nheight_m = 0.0\n"
               "[rig]\nkind = \"none\"\n[[step]]\nkind = \"hold\"\nduration_s = 60\n");
  ASSERT_EQ(run_imulab(folder, "simulate " + name + ".toml -o " + name).exit_code, 0);
}

/// The verbs in the manual's table of saved results; rows of other tables of its page begin with options.
std::set<std::string> verbs_of_the_manual() {
  std::set<std::string> out;
  std::istringstream lines(read_text(IMULAB_SOURCE "/docs/reference/compare.md"));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("| `") && std::islower(static_cast<unsigned char>(line[3])) != 0 && line.find(" | ") != std::string::npos)
      out.insert(line.substr(3, line.find('`', 3) - 3));
  return out;
}

TEST(ReportOfSavedResults, ReadsWhatEachVerbOfTheManualPrints) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& arguments) { return run_imulab(folder, arguments); };
  for (const char* command :
       {"procedure handheld --poses 24 -o hand.toml", "simulate hand.toml -o hand", "calibrate hand --method handheld -o hand.json"})
    ASSERT_EQ(run(command).exit_code, 0) << command;
  ASSERT_EQ(run("procedure six-position -o any.toml").exit_code, 0);
  folder.write("any_drive.toml", R"(format = "imulab.mission/1"
rate_hz = 10
carrier = "vehicle"
[start]
latitude_deg = 45
longitude_deg = 8
height_m = 400
speed_mps = 10
[[segment]]
kind = "straight"
duration_s = 40
[[segment]]
kind = "turn"
angle_deg = 90
rate_dps = 20
[errors]
grade = "mems"
[[aid]]
kind = "gnss"
)");
  ASSERT_EQ(run("trajectory any_drive.toml --errors -o any_drive").exit_code, 0);
  simulate_rest(folder, "any_still");
  const std::multimap<std::string, std::string> commands{{"calibrate", "calibrate hand --method handheld"},
                                                         {"calibrate", "calibrate any_drive --method drive"},
                                                         {"compare", "compare hand.json hand/truth.json"},
                                                         {"noise", "noise any_still"},
                                                         {"predict", "predict any.toml --runs 0"},
                                                         {"predict", "predict any_drive.toml --method drive"},
                                                         {"plan", "plan --mission any_drive.toml --require 'gyro.matrix.zz <= 20000 ppm'"},
                                                         {"plan", "plan --require 'gyro.offset <= 0.05 deg/h'"},
                                                         {"navigate", "navigate none any_drive --vertical fixed"},
                                                         {"navigate", "navigate none any_drive --aided"},
                                                         {"budget", "budget any_drive.toml --runs 0"},
                                                         {"budget", "budget any_drive.toml --grade tactical,mems --runs 0"},
                                                         {"compensate", "compensate hand.json hand -o any.csv"}};
  std::set<std::string> tried;
  for (const auto& [verb, command] : commands) {
    tried.insert(verb);
    const CommandResult result = run(command + " --json");
    EXPECT_LE(result.exit_code, 1) << command << result.errors;
    folder.write("any.json", result.output);
    const CommandResult page = run("report any.json -o any.html");
    EXPECT_EQ(page.exit_code, 0) << command << page.errors;
  }
  EXPECT_EQ(tried, verbs_of_the_manual());
}

}  // namespace
}  // namespace imulab
