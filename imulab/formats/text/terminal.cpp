#include "imulab/formats/text/terminal.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <system_error>
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

std::string part_text(const std::string& label, double part, double elapsed_s) {
  return fmt::format("{}: {:.0f} %, {} left", label, 100 * part, duration_text(elapsed_s * (1 - part) / part));
}

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

bool output_has_color() { return isatty(STDOUT_FILENO) != 0 && colors_wanted(); }
bool errors_have_color() { return isatty(STDERR_FILENO) != 0 && colors_wanted(); }
std::string in_color(Color color, const std::string& text) { return fmt::format("\033[1;{}m{}\033[0m", static_cast<int>(color), text); }

Progress::Progress(std::string label, double total) : label_(std::move(label)), total_(total) {
  if (isatty(STDERR_FILENO) == 0) return;
  try {
    thread_ = std::thread([this] { watch(); });
  } catch (const std::system_error&) {  // no threads here: each report draws the line
    begin_s_ = now_s();
  }
}

Progress::~Progress() {
  if (begin_s_) fmt::print(stderr, "\r\033[K");
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Progress::report(double done) {
  const std::lock_guard lock(mutex_);
  done_ = done;
  if (!begin_s_ || now_s() - drawn_s_ < 0.25) return;
  drawn_s_ = now_s();
  draw(drawn_s_ - *begin_s_);
}

void Progress::draw(double elapsed_s) const {
  fmt::print(stderr, "\r\033[K{}", line(elapsed_s));
  std::fflush(stderr);
}

std::string Progress::line(double elapsed_s) const {
  const double part = done_ / total_;
  if (part > 0) return part_text(label_, part, elapsed_s);
  const auto all = static_cast<double>(reading_.all), read = static_cast<double>(reading_.done);
  if (read > 0 && read <= all) return part_text("reading", read / all, now_s() - reading_.begun_s);
  return fmt::format("{}: {:.0f} s", label_, elapsed_s);
}

void Progress::watch() {
  const double begin_s = now_s();
  bool shown = false;
  std::unique_lock lock(mutex_);
  for (auto pause = std::chrono::milliseconds(1000); !wake_.wait_for(lock, pause, [this] { return finished_; });
       pause = std::chrono::milliseconds(250)) {
    draw(now_s() - begin_s);
    shown = true;
  }
  if (shown) fmt::print(stderr, "\r\033[K");
}

}  // namespace imulab
