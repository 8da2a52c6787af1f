// Loops on several threads, in this one place. In a build without TBB everything is done sequentially, with the same results.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace imulab {

/// Calls `work` once for each of 0 ... count - 1, in any order and several at a time. If calls throw, throws one of their exceptions; calls that have
/// not begun are then skipped. Throws Stopped where a WorkScope around the loop was asked to stop (stop.hpp).
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& work);

/// Calls `work` and isolates its parallel loops: a thread that waits for one of them does not begin work of the enclosing loops on the same
/// stack.
void isolate_parallel(const std::function<void()>& work);

/// Samples that one call of a parallel loop over samples computes.
inline constexpr std::size_t samples_per_task = 1024;

}  // namespace imulab
