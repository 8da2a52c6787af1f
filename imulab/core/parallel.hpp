// Work on several threads: the only place that knows how. In a build without TBB everything is done in turn, with the same results.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace imulab {

/// Calls `work` once for each of 0 ... count - 1, in any order and several at a time. Throws what a call threw, of several any one; calls that have
/// not begun are then left out.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work);

/// Calls `work`, whose parallel loops stay for themselves: a thread that waits for one of them begins nothing of the loops around it on the same
/// stack.
void isolate_parallel(const std::function<void()>& work);

/// Samples that one call of a parallel loop over samples computes.
inline constexpr std::size_t samples_per_task = 1024;

/// The threads of a parallel loop, at least 1.
std::size_t parallel_threads();

/// While it lives, parallel loops of the whole program have at most so many threads.
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
