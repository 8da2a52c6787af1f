// Where imulab-read is looked for, and what it is asked.
#include "imulab/formats/recording/child/read_program.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include "tests/run_command.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tested_build.hpp"
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

namespace imulab::recording_io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(ReadProgram, RequestsArriveAsTheyWere) {
  const ReadRequest request{.format = "HDF5",
                            .task = {"a b.h5", "libhdf5", {123'456'789'012, 7, 42}, 4711},
                            .describes = false,
                            .topic = std::string("/imu\0t", 6),
                            .columns = {"/imu/gyro.1", 3, ""}};
  const ReadRequest got = read_request(to_text(request));
  EXPECT_EQ(got.format, request.format);
  EXPECT_EQ(got.task.file, request.task.file);
  EXPECT_EQ(got.task.library, request.task.library);
  EXPECT_EQ(got.task.limits.memory_bytes, 123'456'789'012u);
  EXPECT_EQ(got.task.limits.computing_s, 7u);
  EXPECT_EQ(got.task.limits.wall_s, 42u);
  EXPECT_EQ(got.task.parent, 4711);
  EXPECT_FALSE(got.describes);
  EXPECT_EQ(got.topic, request.topic);
  EXPECT_EQ(got.columns, request.columns);
  const std::string text = to_text(request);
  for (std::size_t size = 0; size < text.size(); ++size) EXPECT_THROW(read_request(text.substr(0, size)), Error) << size;
}

/// Folders with a program, and one with imulab-read.
struct Installed {
  TemporaryFolder folder;
  fs::path own = folder / "a/b/program";
  Installed() {
    fs::create_directories(own.parent_path());
    folder.write("a/b/program", "");
  }
  fs::path put(const std::string& prefix) const {
    const fs::path place = folder / prefix / "libexec/imulab-read";
    fs::create_directories(place.parent_path());
    fs::copy_file("/bin/true", place);
    return place;
  }
};

TEST(ReadProgram, TheNearestIsTaken) {
  const Installed installed;
  const fs::path above = installed.put("a");
  EXPECT_EQ(find_read_program(installed.own), above);
  const fs::path beside = installed.put("a/b");
  EXPECT_EQ(find_read_program(installed.own), beside);
}

/// The program, or the error.
std::string found_program(const Installed& installed) {
  try {
    return find_read_program(installed.own).string();
  } catch (const Error& e) {
    return e.what();
  }
}

bool is_installed() { return fs::exists("/usr/libexec/imulab-read") || fs::exists("/usr/local/libexec/imulab-read"); }

TEST(ReadProgram, WhereEverybodyMayWriteThereMayBeAnybodysProgram) {
  const Installed installed;
  const fs::path outer = installed.put("a"), inner = installed.put("a/b");
  for (const fs::path& part : {inner, inner.parent_path(), installed.own.parent_path()}) {
    fs::permissions(part, fs::perms::others_write, fs::perm_options::add);
    EXPECT_EQ(found_program(installed), outer) << part;
    fs::remove(outer);
    if (!is_installed()) EXPECT_THAT(found_program(installed), HasSubstr(inner.string() + ": everybody may write to " + part.string() + ", "));
    installed.put("a");
    fs::permissions(part, fs::perms::others_write, fs::perm_options::remove);
  }
  EXPECT_EQ(found_program(installed), inner);
}

TEST(ReadProgram, AFolderIsNoProgram) {
  const Installed installed;
  const fs::path outer = installed.put("a");
  fs::create_directories(installed.folder / "a/b/libexec/imulab-read");
  EXPECT_EQ(found_program(installed), outer);
}

TEST(ReadProgram, TheEnvironmentComesLast) {
  if (is_installed()) GTEST_SKIP() << "imulab is installed";
  const Installed installed;
  const auto message = [&] { return found_program(installed); };
  EXPECT_THAT(message(), HasSubstr("a/b/libexec/imulab-read, "));
  EXPECT_THAT(message(), HasSubstr("/usr/libexec/imulab-read); expected it in libexec beside imulab, as packages install it, or its place in the "
                                   "environment variable IMULAB_READ"));
  ::setenv("IMULAB_READ", "/bin/true", 1);
  EXPECT_EQ(message(), "/bin/true");
  const fs::path beside = installed.put("a/b");
  EXPECT_EQ(message(), beside.string());
  ::unsetenv("IMULAB_READ");
}

/// A command without its imulab-read, and with one that is something else.
TEST(ReadProgram, ErrorsSayWhatToDo) {
  const TableRequest request{.file = recording_file("groups.h5")};
  if (built_without(request)) GTEST_SKIP();
  if (is_installed()) GTEST_SKIP() << "imulab is installed";
  const TemporaryFolder folder;
  fs::copy_file(command_path(), folder / "imulab");
  const std::string inspect = "./imulab inspect '" + request.file.string() + "' --topic /imu/t";
  const CommandResult missing = run_shell(folder, inspect);
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.errors, HasSubstr("groups.h5: is HDF5: the program imulab-read, which reads it, was not found ("));
  const CommandResult wrong = run_shell(folder, "IMULAB_READ=/bin/false " + inspect);
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("imulab-read, the program that reads it, does not start (it ended with code 1)"));
  EXPECT_EQ(run_shell(folder, "IMULAB_READ='" + find_read_program(command_path()).string() + "' " + inspect).exit_code,
            run_shell(folder, "'" + command_path() + "' inspect '" + request.file.string() + "' --topic /imu/t").exit_code);
}

/// Programs are also started without standard input, output and errors.
TEST(ReadProgram, StandardDescriptorsMayBeClosed) {
  const TableRequest request{.file = recording_file("groups.h5"), .topic = "/imu/t"};
  if (built_without(request)) GTEST_SKIP();
  for (const std::vector<int>& closed : std::vector<std::vector<int>>{{}, {0}, {1}, {2}, {0, 1, 2}}) {
    std::vector<int> kept;
    for (const int number : closed) kept.push_back(::fcntl(number, F_DUPFD_CLOEXEC, 10));
    for (const int number : closed) ::close(number);
    const std::string error = error_of(request, {1});
    for (std::size_t k = 0; k < kept.size(); ++k) ::dup2(kept[k], closed[k]), ::close(kept[k]);
    EXPECT_EQ(error, "no error") << testing::PrintToString(closed);
  }
}

TEST(ReadProgram, LimitOnSizesOfFilesIsNamed) {
  const TableRequest request{.file = recording_file("groups.h5")};
  if (built_without(request)) GTEST_SKIP();
  const TemporaryFolder folder;
  const CommandResult result = run_shell(folder, "ulimit -f 512 && '" + command_path() + "' inspect '" + request.file.string() + "' --topic /imu/t");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("groups.h5: cannot be read: no memory to share with imulab-read: File too large; expected a limit on the size "
                                       "of files (ulimit -f) of "));
}

}  // namespace
}  // namespace imulab::recording_io
