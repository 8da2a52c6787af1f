// A result is the same to the last bit on any number of threads, twice in a row, in another folder, locale, time zone and umask, and under valgrind.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// Every verb that computes, and every method, on as little as it accepts.
const std::vector<std::string> verbs{
    "inspect hand/recording.csv -o found.toml --report page",
    "calibrate hand --method static -o c.json --report page",
    "calibrate hand --method handheld -o c.json",
    "calibrate table --method turntable -o c.json",
    "calibrate table --method hybrid -o c.json",
    "calibrate unit --method whole-unit -o c.json",
    "compare hand/truth.json table/truth.json --json",
    "compensate hand/truth.json hand -o out.csv --report page",
    "predict hand.toml --method handheld --json",
    "predict table.toml --method turntable --runs 100 --json",
    "predict table.toml --method hybrid --runs 0 --json --report page",
    "plan --require 'gyro.matrix.diagonal <= 3 ppm' --axes 2 -o plan.toml",
    "simulate table.toml --seed 3 -o again",
    "noise rest -o noise.json --report page",
    "trajectory mission.toml -o again",
    "budget mission.toml --runs 100 --json --report page",
    "navigate none flight -o solution.csv --report page",
    "export hand/truth.json --to all -o exported",
    "fleet calibrate hand hand2 --method handheld --store fleet.db && imulab fleet stats --store fleet.db --json",
};

struct SameBits : testing::Test {
  TemporaryFolder inputs;

  void SetUp() override {
    inputs.write("mission.toml",
                 "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 10\nheight_m = 100\n"
                 "[[segment]]\nkind = \"rest\"\nduration_s = 20\n[errors]\ngrade = \"navigation\"\n");
    for (const char* command :
         {"procedure handheld --poses 12 -o hand.toml", "procedure zhang-24 --rest 5 -o table.toml", "procedure dai-unit -o unit.toml"})
      ASSERT_EQ(run_imulab(inputs, command).exit_code, 0) << command;
    const std::string hand = read_text(inputs / "hand.toml");
    inputs.write("rest.toml", hand.substr(0, hand.find("[[step]]")) + "[[step]]\nkind = \"hold\"\nduration_s = 60\n");
    for (const char* command : {"simulate hand.toml -o hand", "simulate hand.toml --seed 2 -o hand2", "simulate table.toml -o table",
                                "simulate unit.toml -o unit", "simulate rest.toml -o rest", "trajectory mission.toml -o flight"})
      ASSERT_EQ(run_imulab(inputs, command).exit_code, 0) << command;
  }

  struct Surroundings {
    std::string folder = "work", environment{}, before{}, options{};  ///< a shell's commands; what runs the command; its further options
  };

  /// The output and files of the command, without the time of day.
  std::string result_of(const std::string& verb, const Surroundings& in) const {
    const TemporaryFolder work;
    const fs::path place = work / in.folder;
    fs::create_directories(place);
    for (const auto& input : fs::recursive_directory_iterator(inputs.path())) {
      const fs::path name = place / fs::relative(input.path(), inputs.path());
      input.is_directory() ? static_cast<void>(fs::create_directory(name)) : fs::create_symlink(input.path(), name);
    }
    const std::string shell =
        in.environment + "imulab() { " + in.before + " '" + command_path() + "' " + in.options + " \"$@\"; }; cd '" + in.folder + "'; imulab " + verb;
    const CommandResult result = run_shell(work, shell);
    EXPECT_LE(result.exit_code, 1) << shell << result.errors;
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(place))
      if (!entry.is_symlink() && entry.is_regular_file() &&
          entry.path().filename().string().find(".db") == std::string::npos)  // a store has stamps of the time
        files[fs::relative(entry.path(), place).string()] = read_text(entry.path());
    std::string all = result.output;
    for (const auto& [name, text] : files) all += "\n== " + name + "\n" + text;
    static const std::regex stamp("20[0-9]{2}-[0-9]{2}-[0-9]{2}T[0-9:.]+Z");
    return std::regex_replace(all, stamp, "(time)");
  }

  static void expect_equal(const std::string& a, const std::string& b, const std::string& what) {
    if (a == b) return;
    const auto at = static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
    const std::size_t begin = at < 100 ? 0 : at - 100;
    ADD_FAILURE() << what << "\nfirst:  " << a.substr(begin, 200) << "\nsecond: " << b.substr(begin, 200);
  }
};

TEST_F(SameBits, OnAnyThreadsInAnyFolderLocaleTimeZoneAndUmask) {
  const TemporaryFolder locales;
  ASSERT_EQ(run_shell(locales, "localedef -i de_DE -f UTF-8 ./de_DE.UTF-8").exit_code, 0);
  const std::string elsewhere = "export LOCPATH='" + locales.path().string() + "' LC_ALL=de_DE.UTF-8 TZ=Asia/Kathmandu; umask 077; ";
  ASSERT_EQ(run_shell(locales, elsewhere + "locale decimal_point").output, ",\n");  // the locale is in force
  for (const std::string& verb : verbs) {
    const std::string one = result_of(verb, {.options = "--threads 1"});
    expect_equal(one, result_of(verb, {.folder = "a deep/folder \xc3\xa4", .environment = elsewhere, .options = "--threads 2"}), verb);
  }
}

TEST_F(SameBits, UnderValgrindWhichFindsNothing) {  // the verbs that take it some seconds
  // There long double has 64 bits, as on some processors, and a p-value, which is computed in it, may end one digit sooner.
  const auto without_p_values = [](const std::string& text) { return std::regex_replace(text, std::regex("\"p_value\": [^,\n]*"), "(p)"); };
  for (const char* verb : {"calibrate hand --method static -o c.json", "calibrate hand --method handheld -o c.json",
                           "compensate hand/truth.json hand -o out.csv", "export hand/truth.json --to all -o exported"})
    expect_equal(without_p_values(result_of(verb, {})),
                 without_p_values(result_of(verb, {.before = "valgrind -q --error-exitcode=99", .options = "--threads 1"})), verb);
}

}  // namespace
}  // namespace imulab
