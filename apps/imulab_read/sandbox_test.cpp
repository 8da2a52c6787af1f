// What a program in the sandbox tries in vain, and what it has to be able to do.
#include "apps/imulab_read/sandbox.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/child/child.hpp"
#include "imulab/version.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tested_build.hpp"
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <functional>
#include <string>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace imulab::recording_io {
namespace {

using testing::HasSubstr;

bool has(std::string_view option) {
  const auto options = build().options;
  return std::any_of(options.begin(), options.end(), [&](const BuildOption& o) { return o.name == option && o.built_with; });
}

/// What a child says that is in the sandbox: with a file open, or before.
std::string said_in_sandbox(bool closed, const std::function<std::string(int pipe)>& work) {
  const ChildTask task{"imu.h5", "libtest", {.memory_bytes = 1 << 30, .computing_s = 5, .wall_s = 20}};
  std::string said;
  const StartChild start = [&](int pipe, int memory) {
    const pid_t id = ::fork();
    if (id == 0)
      answer_parent(pipe, memory, task, [&](ToParent& to) {
        enter_sandbox(pipe, task.file);
        if (closed) close_sandbox(task.file);
        const std::string text = work(pipe);
        to.next(), to.text(text);
      });
    return id;
  };
  run_in_child(task, start, [&](FromChild& from) { said = from.text(); });
  return said;
}

struct Attempt {
  const char* name;
  std::function<long(int pipe)> call;  // not negative where it is allowed
};

const TemporaryFolder& place() {
  static const TemporaryFolder folder;
  return folder;
}

std::vector<Attempt> attempts() {
  const static std::string readable = place().write("readable", "x"), other = place() / "other";
  return {
      {"open", [](int) { return ::open(readable.c_str(), O_RDONLY); }},
      {"open for writing", [](int) { return ::open(readable.c_str(), O_WRONLY); }},
      {"make a file", [](int) { return ::open(other.c_str(), O_CREAT | O_WRONLY, 0600); }},
      {"remove a file", [](int) { return ::unlink(readable.c_str()); }},
      {"connect by a socket", [](int) { return ::socket(AF_INET, SOCK_STREAM, 0); }},
      {"local socket", [](int) { return ::socket(AF_UNIX, SOCK_DGRAM, 0); }},
      {"run a program",
       [](int) {
         char* none[] = {nullptr};
         ::execve("/bin/true", none, none);
         return -1;  // an allowed one does not come back
       }},
      {"make a process",
       [](int) {
         const pid_t id = ::fork();
         if (id == 0) ::_exit(0);
         return ::waitpid(id, nullptr, 0);
       }},
      {"write to another descriptor", [](int) { return ::write(STDOUT_FILENO, "", 0); }},
      {"executable memory",
       [](int) { return ::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? -1 : 0; }},
      {"end its parent", [](int) { return ::kill(::getppid(), 0); }},
      {"trace its parent", [](int) { return ::ptrace(PTRACE_ATTACH, ::getppid(), nullptr, nullptr); }},
      {"set its limits",
       [](int) {
         rlimit now{};
         ::getrlimit(RLIMIT_CPU, &now);
         return ::setrlimit(RLIMIT_CPU, &now);
       }},
      {"have signals sent", [](int) { return ::fcntl(STDERR_FILENO, F_SETOWN, 0); }},
      {"outlive its parent", [](int) { return ::prctl(PR_SET_PDEATHSIG, 0); }},
      {"put off its end", [](int) { return ::alarm(0) == static_cast<unsigned>(-1) ? -1 : 0; }},
  };
}

TEST(Sandbox, NothingButReadingAndAnswering) {
  if (!has("SECCOMP")) GTEST_SKIP() << "built without libseccomp";
  const std::vector<Attempt> all = attempts();
  for (const bool closed : {false, true}) {
    const std::string allowed = said_in_sandbox(closed, [&](int pipe) {
      std::string names;
      for (const Attempt& attempt : all)
        if (attempt.call(pipe) >= 0) names += std::string(attempt.name) + "\n";
      return names;
    });
    EXPECT_EQ(allowed, closed ? "" : "open\n") << closed;
  }
  // Outside, each of them can be done: the list is not one of impossible things.
  for (const Attempt& attempt : all) {
    const std::string name = attempt.name;
    if (name != "run a program" && name != "trace its parent" && name != "remove a file") EXPECT_GE(attempt.call(STDERR_FILENO), 0) << name;
  }
}

/// As in a system whose kernel has no filters: here the first one keeps the second away.
TEST(Sandbox, WhereThereIsNoneNothingIsRead) {
  if (!has("SECCOMP")) GTEST_SKIP() << "built without libseccomp";
  EXPECT_THAT(said_in_sandbox(true,
                              [](int pipe) {
                                try {
                                  enter_sandbox(pipe, "imu.h5");
                                } catch (const Error& e) {
                                  return std::string(e.what());
                                }
                                return std::string("entered");
                              }),
              HasSubstr("imu.h5: is not read, since this system offers no sandbox for it (seccomp: "));
}

}  // namespace
}  // namespace imulab::recording_io
