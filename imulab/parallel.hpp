// Threads of the library. Methods, predictions, simulations and noise analyses use all processors (oneTBB; builds without it use one). No result
// depends on the number of threads.
//
// Example:
//   const ThreadLimit one(1);  // active while it exists: for a computer with other work, or several calibrations in parallel
//   std::printf("%zu\n", parallel_threads());
//
// A limit applies to the whole program, whichever thread created it; the smallest of several applies. Any thread may call a `progress` callback.
#pragma once

#include <cstddef>
#include <memory>

namespace imulab {

/// Returns the number of threads of a parallel loop, at least 1.
std::size_t parallel_threads();

/// While this object exists, parallel loops of the whole program use at most `threads` threads. Throws Error for 0.
class ThreadLimit {
 public:
  explicit ThreadLimit(std::size_t threads);
  ~ThreadLimit();
  ThreadLimit(ThreadLimit&&) noexcept;
  ThreadLimit& operator=(ThreadLimit&&) noexcept;

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

}  // namespace imulab
