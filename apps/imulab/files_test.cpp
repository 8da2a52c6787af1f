// No verb writes over a file that it reads or writes otherwise, by whatever name; it says so before it computes anything.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <regex>
#include <set>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A command line in which @ is the file to write, and the files that it reads.
struct Row {
  std::string verb, option, command;
  std::vector<std::string> inputs;
};

const std::vector<std::string> session_files{"S/session.toml", "S/recording.csv"};

std::vector<std::string> joined(std::vector<std::string> files, const std::vector<std::string>& more) {
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

const std::vector<Row> written_by{
    {"procedure", "-o", "procedure zhang-24 -o @", {}},
    {"inspect", "-o", "inspect S/recording.csv -o @ --force", {"S/recording.csv"}},
    {"inspect", "--report", "inspect S/recording.csv --report @", {"S/recording.csv"}},
    {"calibrate", "-o", "calibrate S --method handheld -o @ --force", session_files},
    {"calibrate", "--curves", "calibrate S --method hybrid --curves @", session_files},
    {"calibrate", "--report", "calibrate S --method handheld --report @", session_files},
    {"live", "-o", "live S/recording.csv --session S -o @ --force", session_files},
    {"live", "--save", "live S/recording.csv --session S --save @ --force", session_files},
    {"extrinsics", "-o", "extrinsics S S2 -o @", {"S/recording.csv", "S2/session.toml"}},
    {"extrinsics", "--report", "extrinsics S S2 --report @", {"S2/recording.csv"}},
    {"noise", "-o", "noise S -o @ --force", session_files},
    {"noise", "-o", "noise S S2 -o @ --force", {"S2/recording.csv"}},
    {"noise", "--report", "noise S --report @", session_files},
    {"compare", "--report", "compare c.json t.json --report @", {"c.json", "t.json"}},
    {"report", "-o", "report c.json --session-at S -o @", joined(session_files, {"c.json"})},
    {"predict", "--report", "predict p.toml --method handheld --report @", {"p.toml"}},
    {"predict", "-o", "predict z.toml --runs 200 --part 1/1 -o @", {"z.toml"}},
    {"join", "-o", "join part -o @", {"part"}},
    {"join", "--report", "join part --report @", {"part"}},
    {"plan", "-o", "plan --require 'accel.offset <= 1000 ug' -o @", {}},
    {"plan", "--report", "plan --require 'accel.offset <= 1000 ug' --report @", {}},
    {"compensate", "-o", "compensate c.json S -o @", joined(session_files, {"c.json"})},
    {"compensate", "-o", "compensate c.json - --session S -o @ < rows.csv", joined(session_files, {"c.json", "rows.csv"})},
    {"compensate", "--report", "compensate c.json S -o fresh.csv --report @", joined(session_files, {"c.json"})},
    {"export", "-o", "export c.json --noise noise.json --to kalibr -o @ --force", {"c.json", "noise.json"}},
    {"import", "-o", "import c.json --gyro t.json -o @ --force", {"c.json", "t.json"}},
    {"navigate", "-o", "navigate c.json S --truth rows.csv -o @", joined(session_files, {"c.json", "rows.csv"})},
    {"navigate", "--report", "navigate c.json S --report @", joined(session_files, {"c.json"})},
    {"budget", "-o", "budget m.toml --runs 4 --part 1/1 -o @", {"m.toml", "track.csv", "noise.json"}},
    {"budget", "--report", "budget m.toml --runs 0 --report @", {"m.toml", "track.csv", "noise.json"}},
};

/// Verbs whose -o is a folder that they make.
const std::vector<Row> makers{
    {"simulate", "-o", "simulate p.toml -o @", {}}, {"trajectory", "-o", "trajectory m.toml -o @", {}}, {"budget", "-o", "budget m.toml -o @", {}}};

struct Files : testing::Test {
  TemporaryFolder folder;
  void SetUp() override {
    ASSERT_EQ(run_imulab(folder, "procedure handheld --poses 12 -o p.toml").exit_code, 0);
    ASSERT_EQ(run_imulab(folder, "simulate p.toml -o S").exit_code, 0);
    ASSERT_LE(run_imulab(folder, "calibrate S --method handheld -o c.json").exit_code, 1);
    fs::copy(folder / "S", folder / "S2");
    ASSERT_EQ(run_imulab(folder, "procedure zhang-24 -o z.toml").exit_code, 0);
    ASSERT_EQ(run_imulab(folder, "plan --require 'accel.offset <= 1000 ug' --part 1/1 -o part").exit_code, 0);
    fs::copy_file(folder / "S/truth.json", folder / "t.json");
    fs::copy_file(folder / "S/recording.csv", folder / "rows.csv");
    folder.write("noise.json", "{}");
    std::string track = "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n";
    for (int k = 0; k < 40; ++k) track += std::to_string(k) + ",47,8,400,0,0,0,0,0,0\n";
    folder.write("track.csv", track);
    folder.write("m.toml",
                 "format = \"imulab.mission/1\"\n[track]\nfile = \"track.csv\"\n[errors]\ngrade = \"navigation\"\nnoise = \"noise.json\"\n");
  }
  CommandResult run(const Row& row, const std::string& file) const {
    std::string command = row.command;
    return run_imulab(folder, command.replace(command.find('@'), 1, file));
  }
  void expect_refused(const Row& row, const std::string& file, const testing::Matcher<const std::string&>& why) const {
    const CommandResult result = run(row, file);
    EXPECT_EQ(result.exit_code, 2) << row.command << " " << file;
    EXPECT_THAT(result.errors, HasSubstr("imulab: " + row.option + " " + file)) << row.command;
    EXPECT_THAT(result.errors, why) << row.command << " " << file;
    EXPECT_EQ(result.output, "") << row.command;
  }
};

TEST_F(Files, NoOutputReplacesAnInput) {  // ctest: once
  for (const Row& row : written_by)
    for (const std::string& input : row.inputs) {
      const std::string before = read_text(folder / input);
      ASSERT_NE(before, "") << input;
      for (const char* name : {"soft.csv", "hard.csv"}) fs::remove(folder / name);
      fs::create_symlink(input, folder / "soft.csv");
      fs::create_hard_link(folder / input, folder / "hard.csv");
      for (const std::string& name : {input, "S/../" + input, (folder / input).string(), std::string("soft.csv"), std::string("hard.csv")})
        expect_refused(row, name, testing::AnyOf(HasSubstr("would overwrite "), HasSubstr(row.verb == "compensate" ? "a .csv" : "would overwrite ")));
      EXPECT_EQ(read_text(folder / input), before) << row.command;
    }
}

TEST_F(Files, NoOutputReplacesAFolderOrATruth) {  // ctest: once
  for (const Row& row : written_by) {
    const std::string truth = read_text(folder / "S/truth.json");
    if (row.command.find("compensate") != 0) {  // whose -o is a folder, too
      expect_refused(row, "S", HasSubstr("is a folder; expected a file"));
      expect_refused(row, "S/truth.json", HasSubstr("would overwrite the truth of a session"));
    }
    EXPECT_EQ(read_text(folder / "S/truth.json"), truth);
  }
  for (const Row& row : makers) expect_refused(row, "S", HasSubstr("exists; expected a new or an empty folder"));
}

TEST_F(Files, AnOutputWithoutItsFolderEndsItAtOnce) {
  for (const Row& row : written_by) {
    if (row.verb == "compensate" || row.verb == "export") continue;  // whose -o makes its folder, or is read late
    const bool with_output =
        row.option == "--report" && row.command.find(" -o") == std::string::npos && row.verb != "report" && row.verb != "compare";
    const CommandResult result = run(row, with_output ? "none/x -o first.csv" : "none/x");
    EXPECT_EQ(result.exit_code, 2) << row.command;
    EXPECT_THAT(result.errors, HasSubstr("imulab: none/x: cannot be written: none is no folder")) << row.command;
    EXPECT_FALSE(fs::exists(folder / "first.csv")) << row.command;
  }
  EXPECT_EQ(run_imulab(folder, "simulate p.toml -o made/S").exit_code, 0);  // a verb that makes a folder makes those above
  EXPECT_EQ(run_imulab(folder, "compensate c.json S -o made2 --report made2/page.html").exit_code, 0);
}

TEST_F(Files, NoTwoOutputsAreOneFile) {
  fs::create_symlink("x", folder / "link");
  for (const char* command : {"calibrate S --method hybrid -o x --curves @", "calibrate S --method handheld -o x --report @",
                              "plan --require 'accel.offset <= 1000 ug' -o x --report @", "inspect S/recording.csv -o x --report @",
                              "noise S -o x --report @", "live - --session S -o x --save @", "navigate none S -o x --report @"})
    for (const char* name : {"x", "./x", "S/../x", "link"}) {
      std::string line = command;
      const CommandResult result = run_imulab(folder, line.replace(line.find('@'), 1, name));
      EXPECT_EQ(result.exit_code, 2) << line;
      EXPECT_THAT(result.errors, HasSubstr(std::string(name) + ": would overwrite the file of -o; expected another file")) << line;
      EXPECT_FALSE(fs::exists(folder / "x")) << line;
    }
  EXPECT_EQ(run_imulab(folder, "calibrate S --method hybrid -o - --curves -").exit_code, 2);
}

TEST_F(Files, AnExportOfAllAndADemoLeaveOnesOwn) {
  fs::create_directories(folder / "out");
  fs::create_hard_link(folder / "c.json", folder / "out/imu_calibration.h");
  fs::create_hard_link(folder / "c.json", folder / "out/classical.json");
  const std::string before = read_text(folder / "c.json");
  const CommandResult all = run_imulab(folder, "export c.json --to all -o out --force"), demo = run_imulab(folder, "demo -o out");
  EXPECT_EQ(all.exit_code, 2);
  EXPECT_THAT(all.errors, HasSubstr("would overwrite c.json"));
  EXPECT_EQ(demo.exit_code, 2);
  EXPECT_THAT(demo.errors, HasSubstr("-o out: has a classical.json that is not of the demo; expected another folder"));
  EXPECT_EQ(read_text(folder / "c.json"), before);
}

/// A verb or an option that writes and is not in the tables above makes this fail.
TEST_F(Files, EveryOptionThatWritesIsTested) {
  std::set<std::string> tested{"demo -o", "help --man"};
  for (const auto* table : {&written_by, &makers})
    for (const Row& row : *table) tested.insert(row.verb + " " + row.option);
  const std::string all = run_imulab(folder, "--help").output;
  const std::regex verb("^  ([a-z]+) +[A-Z]", std::regex::multiline);
  int verbs = 0;
  std::size_t options = 0;
  for (std::sregex_iterator at(all.begin(), all.end(), verb), end; at != end; ++at, ++verbs) {
    const std::string name = (*at)[1].str() == "procedure" ? "procedure zhang-24" : (*at)[1].str(), help = run_imulab(folder, "help " + name).output;
    for (const std::string option : {"-o", "--report", "--curves", "--save", "--man"}) {
      if (!std::regex_search(help, std::regex("(^|\n) +" + option + "[ ,]"))) continue;
      EXPECT_TRUE(tested.contains((*at)[1].str() + " " + option)) << name << " " << option;
      ++options;
    }
  }
  EXPECT_GE(verbs, 19);
  EXPECT_EQ(options, tested.size());
}

}  // namespace
}  // namespace imulab
