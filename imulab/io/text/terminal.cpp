#include "imulab/io/text/terminal.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <unistd.h>
#include <utility>

namespace imulab {

Progress::Progress(std::string label, std::uint64_t total) : label_(std::move(label)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (terminal_ && shown_ > 0) fmt::print(stderr, "\r\033[K");
}

void Progress::report(std::uint64_t done) {
  if (!terminal_) return;
  const std::lock_guard lock(mutex_);
  if (done < shown_ + total_ / 100) return;  // a hundred times at most
  shown_ = done;
  fmt::print(stderr, "\r{}: {} of {}", label_, done, total_);
  std::fflush(stderr);
}

}  // namespace imulab
