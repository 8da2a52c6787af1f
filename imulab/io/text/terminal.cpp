#include "imulab/io/text/terminal.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <unistd.h>
#include <utility>

namespace imulab {

namespace {

bool colors_wanted() {
  const char* const no = std::getenv("NO_COLOR");
  return no == nullptr || *no == '\0';
}

std::string duration_text(double seconds) {
  return seconds < 100 ? fmt::format("{:.0f} s", std::ceil(seconds)) : fmt::format("{:.0f} min", std::ceil(seconds / 60));
}

}  // namespace

bool output_has_color() { return isatty(STDOUT_FILENO) != 0 && colors_wanted(); }
bool errors_have_color() { return isatty(STDERR_FILENO) != 0 && colors_wanted(); }
std::string in_color(Color color, const std::string& text) { return fmt::format("\033[1;{}m{}\033[0m", static_cast<int>(color), text); }

Progress::Progress(std::string label, std::uint64_t total) : label_(std::move(label)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (terminal_ && shown_ > 0) fmt::print(stderr, "\r\033[K");
}

void Progress::report(std::uint64_t done) {
  if (!terminal_) return;
  const std::lock_guard lock(mutex_);
  if (done < shown_ + total_ / 100) return;  // a hundred times at most
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (elapsed < 1 || done == 0) return;
  shown_ = done;
  const double fraction = static_cast<double>(done) / static_cast<double>(total_);
  fmt::print(stderr, "\r\033[K{}: {:.0f} %, {} left", label_, 100 * fraction, duration_text(elapsed * (1 - fraction) / fraction));
  std::fflush(stderr);
}

Elapsed::Elapsed(std::string label) {
  if (isatty(STDERR_FILENO) == 0) return;
  thread_ = std::thread([this, label = std::move(label)] {
    std::unique_lock lock(mutex_);
    for (int seconds = 1; !done_.wait_for(lock, std::chrono::seconds(1), [this] { return finished_; }); ++seconds) {
      if (seconds < 2) continue;
      shown_ = true;
      fmt::print(stderr, "\r\033[K{}: {} s", label, seconds);
      std::fflush(stderr);
    }
  });
}

Elapsed::~Elapsed() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  done_.notify_one();
  thread_.join();
  if (shown_) fmt::print(stderr, "\r\033[K");
}

}  // namespace imulab
