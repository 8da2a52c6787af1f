#include "imulab/core/parallel.hpp"

#include "imulab/parallel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <vector>

namespace imulab {
namespace {

TEST(Parallel, EveryCallIsMadeOnce) {
  for (const std::size_t count : {0u, 1u, 1000u}) {
    std::vector<std::atomic<int>> calls(count);
    parallel_for(count, [&](std::size_t k) { ++calls[k]; });
    for (const auto& n : calls) EXPECT_EQ(n, 1);
  }
}

TEST(Parallel, WhatACallThrowsIsThrown) {
  EXPECT_THROW(parallel_for(100, [](std::size_t k) { k == 50 ? throw std::runtime_error("50") : void(); }), std::runtime_error);
  EXPECT_THROW(isolate_parallel([] { throw std::runtime_error("here"); }), std::runtime_error);
}

/// Without isolation a thread that waits for its inner loop begins another call of the outer one, inside the first.
TEST(Parallel, AnIsolatedLoopBeginsNothingOfTheOneAround) {
  std::atomic<int> nested = 0, inner = 0;
  parallel_for(200, [&](std::size_t) {
    thread_local int depth = 0;
    if (++depth > 1) ++nested;
    isolate_parallel([&] { parallel_for(50, [&](std::size_t) { ++inner; }); });
    --depth;
  });
  EXPECT_EQ(nested, 0);
  EXPECT_EQ(inner, 200 * 50);
}

TEST(Parallel, ThreadsCanBeLimited) {
  const std::size_t usual = parallel_threads();
  EXPECT_GE(usual, 1u);
  {
    const ThreadLimit one(1);
    std::atomic<int> at_once = 0, most = 0;
    parallel_for(1000, [&](std::size_t) {
      most = std::max<int>(most, ++at_once);
      --at_once;
    });
    EXPECT_EQ(most, 1);
    EXPECT_EQ(parallel_threads(), 1u);
  }
  EXPECT_EQ(parallel_threads(), usual);
}

}  // namespace
}  // namespace imulab
