#include "imulab/formats/text/lost_pages.hpp"

#include "imulab/formats/text/file.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <unistd.h>

namespace imulab {

namespace {

/// What a signal handler may read: no lock, no allocation.
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
