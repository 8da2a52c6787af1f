#include "imulab/formats/text/unfinished.hpp"

#include "imulab/formats/text/file.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <new>
#include <set>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace imulab {

namespace {

struct Registry {
  std::mutex mutex;
  std::multiset<std::filesystem::path> paths;
};

/// Never destroyed: the thread below may look at it at any time.
Registry& registry() {
  static Registry* const all = new Registry;
  return *all;
}

int signal_pipe[2] = {-1, -1};

/// A handler must do no more: a thread does the rest.
void pass_on(int number) {
  const auto byte = static_cast<unsigned char>(number);
  [[maybe_unused]] const ssize_t written = ::write(signal_pipe[1], &byte, 1);
}

constexpr int wrong_input = 2;  // exit code

/// The file that is being read is lost: this thread cannot go on.
void end_for_lost_pages() {
  pass_on(SIGBUS);
  for (;;) ::pause();
}

const char* memory_message = "";
std::atomic_flag memory_has_ended = ATOMIC_FLAG_INIT;
std::atomic<bool> is_waited_for_signals = false;
thread_local bool removes_unfinished = false;

void end_for_memory() {
  if (removes_unfinished) ::_exit(wrong_input);
  if (!memory_has_ended.test_and_set()) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, memory_message, std::strlen(memory_message));
    if (!is_waited_for_signals) ::_exit(wrong_input);
    pass_on(SIGBUS);
  }
  for (;;) ::pause();
}

void wait_for_signal() {
  removes_unfinished = true;
  unsigned char number = 0;
  while (::read(signal_pipe[0], &number, 1) != 1) {
  }
  Registry& all = registry();
  const std::scoped_lock lock(all.mutex);
  std::error_code ignored;
  for (const std::filesystem::path& path : all.paths) std::filesystem::remove_all(path, ignored);
  if (number == SIGBUS) ::_exit(wrong_input);
  std::signal(number, SIG_DFL);
  ::kill(::getpid(), number);
  for (;;) ::pause();  // with the lock: nothing is finished any more
}

}  // namespace

void begin_unfinished(const std::filesystem::path& path) {
  std::multiset<std::filesystem::path> one{path};  // no memory is asked for with the lock, which the thread below takes when memory has ended
  const std::scoped_lock lock(registry().mutex);
  registry().paths.merge(one);
}

void end_unfinished(const std::filesystem::path& path) {
  const std::scoped_lock lock(registry().mutex);
  if (const auto at = registry().paths.find(path); at != registry().paths.end()) registry().paths.erase(at);
}

void end_when_memory_ends(const char* message) {
  memory_message = message;
  std::set_new_handler(end_for_memory);
}

void remove_unfinished_on_signals() {
  int ends[2];
  if (signal_pipe[0] >= 0 || ::pipe2(ends, O_CLOEXEC) != 0) return;
  // A closed standard stream leaves its number free: the pipe must not become the standard input.
  for (int i = 0; i < 2; ++i) signal_pipe[i] = ::fcntl(ends[i], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  for (const int end : ends) ::close(end);
  if (signal_pipe[0] < 0 || signal_pipe[1] < 0) return;
  try {
    std::thread(wait_for_signal).detach();
  } catch (const std::system_error&) {  // no threads here: a signal ends the program at once
    return;
  }
  is_waited_for_signals = true;
  explain_lost_pages(end_for_lost_pages);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {
    }, action{};
    action.sa_handler = pass_on;
    action.sa_flags = SA_RESTART;
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) ::sigaction(number, &action, nullptr);
  }
}

namespace {

/// Data that a signal handler may read: no lock, no allocation.
struct MappedBytes {
  std::atomic<std::uintptr_t> begin{0}, end{0};
  std::atomic<const char*> message{nullptr};
  std::atomic<std::size_t> message_size{0};
};
std::array<MappedBytes, 64> all_mapped;  // a file that finds no place here is read all the same
std::atomic<bool> said{false};
void (*leave)() = nullptr;
pid_t own_process = 0;

void on_bus_error(int, siginfo_t* info, void*) {
  const auto at = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (const MappedBytes& bytes : all_mapped) {
    if (at < bytes.begin || at >= bytes.end || ::getpid() != own_process) continue;
    [[maybe_unused]] ssize_t written = 0;
    if (!said.exchange(true)) written = ::write(STDERR_FILENO, bytes.message, bytes.message_size);  // several threads may read it
    leave();
  }
  std::signal(SIGBUS, SIG_DFL);  // and the same instruction again
}

}  // namespace

std::string lost_text(const std::filesystem::path& path) {
  return input_name(path) + ": became shorter while it was read; expected a file that no other program changes";
}

void begin_mapped(const char* data, std::size_t size, const std::string& message) {
  for (MappedBytes& bytes : all_mapped) {
    std::uintptr_t free = 0;
    if (!bytes.begin.compare_exchange_strong(free, reinterpret_cast<std::uintptr_t>(data))) continue;
    bytes.message_size = message.size(), bytes.message = message.data();
    bytes.end = reinterpret_cast<std::uintptr_t>(data) + size;
    return;
  }
}

void end_mapped(const char* data) {
  for (MappedBytes& bytes : all_mapped)
    if (bytes.begin == reinterpret_cast<std::uintptr_t>(data)) bytes.end = 0, bytes.begin = 0;
}

void explain_lost_pages(void (*remove_unfinished_and_exit)()) {
  leave = remove_unfinished_and_exit, own_process = ::getpid();
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &action, nullptr);
}

}  // namespace imulab
