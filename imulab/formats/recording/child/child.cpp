#include "imulab/formats/recording/child/child.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <mutex>
#include <new>
#include <string_view>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#ifdef IMULAB_ADDRESS_SANITIZER
#include <sanitizer/common_interface_defs.h>
#endif

namespace imulab::recording_io {
namespace {

/// The address space that the program takes now.
[[maybe_unused]] std::uint64_t addresses_bytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Closes all descriptors but the standard ones and these two. Throws where they cannot be known: a kernel without close_range and /proc.
void keep_only(int one, int other) {
  const auto [low, high] = std::minmax(static_cast<unsigned>(one), static_cast<unsigned>(other));
  constexpr unsigned first = STDERR_FILENO + 1;
  const auto closed = [](unsigned from, unsigned to) { return from > to || ::close_range(from, to, 0) == 0; };
  if (low >= first && closed(first, low - 1) && closed(low + 1, high - 1) && closed(high + 1, ~0U)) return;
  std::vector<int> open;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) open.push_back(std::stoi(entry.path().filename()));
  for (const int number : open)
    if (number > STDERR_FILENO && number != one && number != other) ::close(number);
}

/// The child dies of what goes wrong, says nothing, leaves no core file, writes no other file, and does not outlive its parent.
void prepare_child(const ChildLimits& limits, pid_t parent) {
  std::set_new_handler(nullptr);  // the parent's may end it by a thread that is not here
  for (int number = 1; number < NSIG; ++number) {
    struct sigaction now {};
    const bool deadly = number == SIGALRM || number == SIGXCPU || number == SIGSEGV || number == SIGABRT || number == SIGPIPE;
    if (::sigaction(number, nullptr, &now) == 0 && (deadly || now.sa_handler != SIG_IGN)) std::signal(number, SIG_DFL);
  }
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it died before that
  if (const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC); nothing >= 0) {
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, standard);
    if (nothing > STDERR_FILENO) ::close(nothing);
  }
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_FSIZE, 0);
  lower_limit(RLIMIT_CPU, limits.computing_s);
#ifdef IMULAB_ADDRESS_SANITIZER
  __sanitizer_set_death_callback(nullptr);  // a fuzzer's: what the library does wrong is no finding
#else
  lower_limit(RLIMIT_AS, addresses_bytes() + limits.memory_bytes);
#endif
  ::alarm(limits.wall_s);
}

/// A running child and the pipe from it; stopped and waited for at the end, so that no zombie stays.
class Child {
 public:
  Child(pid_t id, int descriptor) : id_(id), descriptor_(descriptor) {}
  ~Child() {
    ::close(descriptor_);
    if (id_ > 0) end({});
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int descriptor() const { return descriptor_; }

  /// The child's exit status; it is killed if it still runs after `grace`. 0 in a program that ignores its children and is not told.
  int end(std::chrono::milliseconds grace) {
    const pid_t id = std::exchange(id_, 0);
    const auto last = std::chrono::steady_clock::now() + grace;
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(id, &status, WNOHANG)) == 0 && std::chrono::steady_clock::now() < last)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (ended == 0) {
      ::kill(id, SIGKILL);
      while ((ended = ::waitpid(id, &status, 0)) < 0 && errno == EINTR) {
      }
    }
    return ended > 0 ? status : 0;
  }

 private:
  pid_t id_;
  int descriptor_;
};

Child start_child(const ChildTask& task, SharedSlots& slots, const StartChild& start) {
  // One at a time, so that no child holds another's end of a pipe open.
  static std::mutex starting;
  const std::lock_guard lock(starting);
  int ends[2];
  const auto fail = [&](const char* what) {
    throw Error(fmt::format("{}: cannot be read: {}: {}", task.file.string(), what, std::generic_category().message(errno)));
  };
  if (::pipe2(ends, O_CLOEXEC) != 0) fail("no pipe");
  for (int& end : ends) end = beyond_standard(end);
  const bool piped = ends[0] >= 0 && ends[1] >= 0 && ::fcntl(ends[0], F_SETFL, O_NONBLOCK) == 0;
  const pid_t id = piped ? start(ends[1], slots.descriptor()) : -1;
  const int why = errno;
  ::close(ends[1]);
  if (id < 0) {
    ::close(ends[0]);
    errno = why;
    fail(piped ? "no process" : "no pipe");
  }
  return {id, ends[0]};
}

SharedSlots memory_to_share(const ChildTask& task) try { return SharedSlots(); } catch (const std::system_error& e) {
  const std::string need =
      e.code().value() == EFBIG
          ? fmt::format("; expected a limit on the size of files (ulimit -f) of {} bytes or more, which holds for memory, too", SharedSlots::bytes())
          : "";
  throw Error(fmt::format("{}: cannot be read: no memory to share with imulab-read: {}{}", task.file.string(), e.code().message(), need));
}

/// Why there is no answer; `status`: how the process ended.
std::string end_of(NoAnswer why, int status, const ChildLimits& limits) {
  const std::string late = fmt::format("no end after {} s", limits.wall_s), nonsense = "its answer makes no sense";
  if (why != NoAnswer::ended) return why == NoAnswer::late ? late : nonsense;
  if (!WIFSIGNALED(status)) return fmt::format("it ended with code {}", WIFEXITED(status) ? WEXITSTATUS(status) : 0);
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU) return fmt::format("no end after {} s of computing", limits.computing_s);
  if (signal == SIGALRM) return late;
  const char* const name = ::sigdescr_np(signal);
  std::string how = name != nullptr ? name : fmt::format("signal {}", signal);
  std::transform(how.begin(), how.begin() + 1, how.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return how;
}

std::string failure(const ChildTask& task, const std::string& how, bool began) {
  const std::string file = task.file.string();
  if (began) return fmt::format("{}: is damaged: {} failed on it ({}); expected a whole file", file, task.library, how);
  return fmt::format("{}: cannot be read: imulab-read, the program that reads it, does not start ({}); expected the one that belongs to this imulab",
                     file, how);
}

}  // namespace

ChildLimits child_limits(std::uint64_t file_bytes) {
  constexpr std::uint64_t megabyte = 1'000'000, most_packed = 2200;
  const auto machine = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t file = std::min<std::uint64_t>(file_bytes, machine) * most_packed;
  const auto computing_s = static_cast<unsigned>(10 + std::min<std::uint64_t>(file_bytes / megabyte, 1'000'000));
  return {std::min(512 * megabyte + file, machine), computing_s, 6 * computing_s};
}

ChildTask child_task(const std::filesystem::path& file, const std::string& library) {
  std::error_code missing;
  const std::uintmax_t bytes = std::filesystem::file_size(file, missing);
  return {file, library, child_limits(missing ? 0 : bytes)};
}

void run_in_child(const ChildTask& task, const StartChild& start, const std::function<void(FromChild&)>& take) {
  using namespace std::chrono_literals;
  SharedSlots slots = memory_to_share(task);
  Child child = start_child(task, slots, start);
  const auto last = std::chrono::steady_clock::now() + std::chrono::seconds(task.limits.wall_s) + 1s;  // a child that puts off no alarm ends before
  FromChild from(child.descriptor(), slots, task.limits.memory_bytes, last);
  std::string error;
  bool began = false;
  try {
    if (from.number() != ChildMarks::begin) from.reject();
    began = true;
    std::uint64_t mark = 0;
    while ((mark = from.number()) == ChildMarks::part) take(from);
    if (mark == ChildMarks::error) error = from.text(), mark = from.number();
    if (mark != ChildMarks::end) from.reject();
  } catch (const NoAnswer why) {
    const int status = child.end(why == NoAnswer::ended ? 100ms : 0ms);  // one whose answer ended is about to
    throw Error(failure(task, end_of(why, status, task.limits), began));
  }
  if (!error.empty()) throw Error(error);
}

[[noreturn]] void answer_parent(int pipe, int memory, const ChildTask& task, const std::function<void(ToParent&)>& work) try {
  keep_only(pipe, memory);
  prepare_child(task.limits, task.parent);
  SharedSlots slots(memory);
  ToParent to(pipe, slots);
  to.number(ChildMarks::begin);
  to.flush();
  const auto fail = [&](std::string_view text) {
    to.number(ChildMarks::error);
    to.text(text);
  };
  try {
    work(to);
  } catch (const Error& e) {
    fail(e.what());
  } catch (const std::bad_alloc&) {
    fail(fmt::format("{}: is damaged: {} needs more memory for it than a file of its size can hold", task.file.string(), task.library));
  } catch (const std::exception& e) {
    fail(fmt::format("{}: {}", task.file.string(), e.what()));
  }
  to.number(ChildMarks::end);
  to.flush();
  ::_exit(0);  // without the program's destructors and unwritten output
} catch (...) {
  ::_exit(1);
}

void lower_limit(int resource, std::uint64_t most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  now.rlim_cur = std::min(now.rlim_cur, static_cast<rlim_t>(most));
  now.rlim_max = std::min(now.rlim_max, static_cast<rlim_t>(most) + (resource == RLIMIT_CPU ? 1 : 0));  // SIGXCPU comes before SIGKILL
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

}  // namespace imulab::recording_io
