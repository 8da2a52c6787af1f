// The threads of the library. Methods, predictions, simulations and noise analyses use all processors by themselves (oneTBB; in a build without it
// one); no result depends on their number.
//
// Example:
//   const ThreadLimit one(1);  // while it exists: for a node that has other work, or that calibrates several units side by side
//   std::printf("%zu\n", parallel_threads());
//
// A limit counts for the whole program, whichever thread made it; of several the least. Callbacks named `progress` may come from any thread.
#pragma once

#include <cstddef>
#include <memory>

namespace imulab {

/// The threads of a parallel loop, at least 1.
std::size_t parallel_threads();

/// While it exists, parallel loops of the whole program use at most this number of threads, from 1 on. Throws Error for 0.
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
