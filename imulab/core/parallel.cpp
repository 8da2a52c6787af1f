#include "imulab/core/parallel.hpp"

#include "imulab/error.hpp"
#include "imulab/parallel.hpp"
#include "imulab/stop.hpp"

#ifdef IMULAB_WITH_TBB
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#endif

namespace imulab {
namespace {

std::size_t expect_threads(std::size_t threads) {
  if (threads == 0) throw Error("a limit of 0 threads; expected at least 1");
  return threads;
}

}  // namespace

#ifdef IMULAB_WITH_TBB
struct ThreadLimit::Control {
  tbb::global_control control;
};
ThreadLimit::ThreadLimit(std::size_t threads) : control_(new Control{{tbb::global_control::max_allowed_parallelism, expect_threads(threads)}}) {}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work) {
  const ScopesOfThread scopes;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) { scopes.call(work, k); });
}
void isolate_parallel(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }
std::size_t parallel_threads() {
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(limit, static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
}
#else
struct ThreadLimit::Control {};
ThreadLimit::ThreadLimit(std::size_t threads) { expect_threads(threads); }

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work) {
  for (std::size_t k = 0; k < count; ++k) {
    stop_point();
    work(k);
  }
}
void isolate_parallel(const std::function<void()>& work) { work(); }
std::size_t parallel_threads() { return 1; }
#endif

ThreadLimit::~ThreadLimit() = default;
ThreadLimit::ThreadLimit(ThreadLimit&&) noexcept = default;
ThreadLimit& ThreadLimit::operator=(ThreadLimit&&) noexcept = default;

}  // namespace imulab
