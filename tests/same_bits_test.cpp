// A result is the same to the last bit on any number of threads, twice in a row, in another folder, locale, time zone and umask of one machine; and
// to rounding, a hundredth of its uncertainty, where the mathematical library takes other variants of its functions: on other processors, under
// valgrind.
// ctest: bits
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/console_page.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
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

  /// The files of the command by their names, and its output under "".
  std::map<std::string, std::string> files_of(const std::string& verb, const Surroundings& in) const {
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
    std::map<std::string, std::string> files{{"", result.output}};
    for (const auto& entry : fs::recursive_directory_iterator(place))
      if (!entry.is_symlink() && entry.is_regular_file() &&
          entry.path().filename().string().find(".db") == std::string::npos)  // a store has stamps of the time
        files[fs::relative(entry.path(), place).string()] = read_text(entry.path());
    return files;
  }

  /// The output and files of the command, without the time of day.
  std::string result_of(const std::string& verb, const Surroundings& in) const {
    std::string all;
    for (const auto& [name, text] : files_of(verb, in)) all += "\n== " + name + "\n" + text;
    static const std::regex stamp("20[0-9]{2}-[0-9]{2}-[0-9]{2}T[0-9:.]+Z");
    return std::regex_replace(all, stamp, "(time)");
  }

  static void expect_equal(const std::string& a, const std::string& b, const std::string& what) {
    if (a == b) return;
    const auto at = static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
    const std::size_t begin = at < 100 ? 0 : at - 100;
    ADD_FAILURE() << what << "\nfirst:  " << a.substr(begin, 200) << "\nsecond: " << b.substr(begin, 200);
  }

  /// Coefficients differ by a hundredth of their uncertainties at most, which differ by a hundredth.
  static void expect_close_calibrations(const std::string& a, const std::string& b, const std::string& what) {
    const TemporaryFolder folder;
    folder.write("a.json", a);
    folder.write("b.json", b);
    const Calibration one = read_calibration(folder / "a.json"), other = read_calibration(folder / "b.json");
    EXPECT_EQ(one.quality.verdict, other.quality.verdict) << what;
    ASSERT_EQ(one.estimated, other.estimated) << what;
    for (const CoefficientIndex i : one.estimated) {
      const auto u = standard_uncertainty(one, i), v = standard_uncertainty(other, i);
      ASSERT_TRUE(u && v) << what;
      EXPECT_NEAR(*u, *v, 0.01 * *u) << what << coefficient(i).name;
      EXPECT_NEAR(coefficient_value(one.model, i), coefficient_value(other.model, i), 0.01 * *u) << what << coefficient(i).name;
    }
  }

  /// The same words, and numbers that differ by 1e-9 of their size at most: what is left of 16 digits where 7 cancel.
  static void expect_close_texts(const std::string& a, const std::string& b, const std::string& what) {
    const std::vector<std::string> one = page_lines(a), other = page_lines(b);
    ASSERT_EQ(one.size(), other.size()) << what;
    for (std::size_t i = 0; i < one.size(); ++i)
      EXPECT_TRUE(one[i] == other[i] || says(one[i], other[i], 1e-9)) << what << one[i] << "\n" << other[i];
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

TEST_F(SameBits, ToRoundingUnderValgrindWhichFindsNothingAndOnOtherProcessors) {  // the verbs that take it some seconds
  const Surroundings valgrind{.before = "valgrind -q --error-exitcode=99", .options = "--threads 1"};
  const Surroundings older{.environment = "export GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA; "};  // a processor, as glibc sees it
  for (const std::string verb : {"calibrate hand --method static -o c.json", "calibrate hand --method handheld -o c.json",
                                 "compensate hand/truth.json hand -o out.csv", "export hand/truth.json --to all -o exported"}) {
    const auto here = files_of(verb, {});
    for (const Surroundings& in : {valgrind, older}) {
      const auto there = files_of(verb, in);
      ASSERT_EQ(here.size(), there.size()) << verb;
      for (const auto& [name, text] : here) {
        ASSERT_TRUE(there.contains(name)) << verb << ": " << name;
        (name == "c.json" ? expect_close_calibrations : expect_close_texts)(text, there.at(name), verb + ": " + name + "\n");
      }
    }
  }
}

}  // namespace
}  // namespace imulab
