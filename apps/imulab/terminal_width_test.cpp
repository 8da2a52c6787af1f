// The text that the command prints for people fits a terminal of 80 columns.
// ctest: once
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <vector>

namespace imulab {
namespace {

std::size_t columns_of(const std::string& line) {  // code points of UTF-8
  return static_cast<std::size_t>(std::count_if(line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

TEST(TerminalWidth, NoLineOfAResultIsLongerThanEightyColumns) {
  const TemporaryFolder folder;
  const std::vector<std::string> commands{
      "procedure handheld -o hand.toml",
      "procedure zhang-24 -o zhang.toml",
      "procedure cheng-path -o path.toml",
      "procedure dai-unit -o unit.toml",
      "simulate hand.toml -o hand",
      "simulate path.toml -o path",
      "inspect hand/recording.csv",
      "calibrate hand --method handheld -o a.json --verbose",
      "calibrate hand --method static -o b.json --verbose",
      "calibrate path --method hybrid -o c.json --verbose",
      "compare a.json hand/truth.json",
      "compare a.json b.json hand/truth.json --verbose",
      "compare a.json b.json c.json d1.json d2.json d3.json d4.json d5.json hand/truth.json --verbose",
      "budget m.toml --runs 20 --grade strategic,navigation,tactical,mems,mems-30g --verbose",
      "verify a.json",
      "compensate a.json hand -o compensated.csv --reject-outliers",
      "predict zhang.toml --runs 0 --verbose",
      "predict hand.toml --method static",
      "predict hand.toml --method handheld --require 'gyro.matrix.diagonal <= 100 ppm'",
      "predict path.toml --method hybrid",
      "predict unit.toml --method whole-unit",
      "plan --require 'gyro.matrix.diagonal <= 3 ppm' --axes 2",
      "fleet add a.json b.json --store fleet.db",
      "fleet list --store fleet.db",
      "fleet stats --store fleet.db",
  };
  folder.write("m.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 5\n[start]\nlatitude_deg = 47\nlongitude_deg = 8\nheight_m = 400\n"
               "[[segment]]\nkind = \"accelerate\"\nto_mps = 200\nduration_s = 60\n");
  for (const std::string& command : commands) {
    if (command.starts_with("compare a.json b.json c.json"))
      for (const std::string name : {"d1", "d2", "d3", "d4", "d5"}) folder.write(name + ".json", read_text(folder / "b.json"));
    const CommandResult result = run_imulab(folder, command);
    EXPECT_LE(result.exit_code, 1) << command << "\n" << result.errors;
    std::istringstream lines(result.output);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(columns_of(line), 80u) << command << "\n" << line;
  }
}

}  // namespace
}  // namespace imulab
