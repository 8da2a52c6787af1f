// What the programs load, and how new a system they need.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/tested_build.hpp"
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <gnu/libc-version.h>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string output_of(const std::string& command) {
  const TemporaryFolder folder;
  const CommandResult result = run_shell(folder, command);
  EXPECT_EQ(result.exit_code, 0) << command << result.errors;
  return result.output;
}

/// Not a script that runs it in an emulator, nor under sanitizers.
bool is_program() {
  return !under_sanitizers() && read_text(command_path())
                                    .starts_with(
                                        "\x7F"
                                        "ELF");
}

/// The newest version of that name that a program asks of a library: 2.35 as 2035000, 3.4.30 as 3004030.
long newest(const std::string& program, const std::string& name) {
  const std::string symbols = output_of("objdump -T '" + program + "'");
  const std::regex version(name + "_([0-9]+)\\.([0-9]+)(?:\\.([0-9]+))?\\b");
  long most = 0;
  for (std::sregex_iterator i(symbols.begin(), symbols.end(), version), end; i != end; ++i) {
    long number = 0;
    for (int k = 1; k <= 3; ++k) number = 1000 * number + std::atol((*i)[k].str().c_str());
    most = std::max(most, number);
  }
  return most;
}

std::vector<std::string> programs() {
  std::vector<std::string> all{command_path()};
  if (const auto place = std::filesystem::path(command_path()).parent_path() / "libexec/imulab-read"; std::filesystem::exists(place))
    all.push_back(place);
  return all;
}

TEST(LinkedLibraries, AreFewAndNoneOfThemReadsHostileFilesOrTheNetwork) {
  if (!is_program()) GTEST_SKIP();
  const std::string loaded = output_of("ldd '" + command_path() + "'");
  EXPECT_LE(std::count(loaded.begin(), loaded.end(), '\n'), 16) << loaded;
  for (const std::string& program : programs()) {
    const std::string libraries = output_of("ldd '" + program + "'");
    for (const char* name : {"curl", "ldap", "ssl", "gnutls"}) EXPECT_THAT(libraries, Not(HasSubstr(name))) << program;
  }
  for (const char* name : {"hdf5", "matio", "seccomp"}) EXPECT_THAT(loaded, Not(HasSubstr(name)));
  EXPECT_THAT(output_of("nm -C '" + command_path() + "' | grep -c H5Dread || true"), testing::StartsWith("0"));
}

/// Ubuntu 22.04 has glibc 2.35 and libstdc++ 12.3, older than Debian 12's glibc: no call that came later.
TEST(LinkedLibraries, AreThoseOfUbuntu2204OrOlder) {
  if (!is_program()) GTEST_SKIP();
  int major = 0, minor = 0;
  if (std::sscanf(::gnu_get_libc_version(), "%d.%d", &major, &minor) == 2 && (major > 2 || minor > 36))
    GTEST_SKIP() << "a newer system than Debian 12";
  for (const std::string& program : programs()) {
    EXPECT_LE(newest(program, "GLIBC"), 2'035'000) << program;
    EXPECT_LE(newest(program, "GLIBCXX"), 3'004'030) << program;
    EXPECT_GT(newest(program, "GLIBC"), 2'000'000) << program;
  }
}

}  // namespace
}  // namespace imulab
