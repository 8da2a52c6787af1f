#include "imulab/recording/resampling.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace imulab {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;

std::vector<std::int64_t> even_stamps(std::size_t n, std::int64_t first_ns, std::int64_t step_ns) {
  std::vector<std::int64_t> t(n);
  for (std::size_t i = 0; i < n; ++i) t[i] = first_ns + static_cast<std::int64_t>(i) * step_ns;
  return t;
}
constexpr std::int64_t ms = 1'000'000;

TEST(Resample, AFasterSourceIsAveraged) {
  const auto r = resample_means(even_stamps(6, 1 * ms, 1 * ms), 1e-3, {{1, 2, 3, 4, 5, 6}}, false, even_stamps(2, 3 * ms, 3 * ms), 3e-3);
  EXPECT_THAT(r.columns[0], ElementsAre(DoubleEq(2), DoubleEq(5)));
  EXPECT_THAT(r.covered, ElementsAre(1, 1));
}

TEST(Resample, ASlowerSourceHoldsItsMean) {
  const auto r = resample_means(even_stamps(2, 3 * ms, 3 * ms), 3e-3, {{2, 5}}, false, even_stamps(6, 1 * ms, 1 * ms), 1e-3);
  EXPECT_THAT(r.columns[0], ElementsAre(DoubleEq(2), DoubleEq(2), DoubleEq(2), DoubleEq(5), DoubleEq(5), DoubleEq(5)));
}

TEST(Resample, WhatAccumulatesIsKept) {
  // A rate that changes, at 1000 Hz and at 300 Hz with another phase: the angle between two common instants is the same.
  std::vector<double> rate(1000);
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = std::sin(0.01 * static_cast<double>(i));
  const auto source = even_stamps(1000, 1 * ms, 1 * ms), target = even_stamps(300, 400'000 + 3 * ms, 3'300'000);
  for (const bool increment : {false, true}) {
    const auto r = resample_means(source, 1e-3, {rate}, increment, target, 3.3e-3);
    double sum = 0, expected = 0;
    for (std::size_t i = 1; i < 200; ++i) sum += r.columns[0][i] * (increment ? 1 : 3.3);  // from target[0] to target[199]
    for (std::size_t k = 0; k < source.size(); ++k) {
      const double overlap = static_cast<double>(std::min(source[k], target[199]) - std::max(source[k] - ms, target[0])) / ms;
      if (overlap > 0) expected += overlap * rate[k];
    }
    EXPECT_NEAR(sum, expected, 1e-9) << increment;  // rounding of sums of a thousand
  }
}

TEST(Resample, GapsAreNotCovered) {
  auto source = even_stamps(10, 1 * ms, 1 * ms);
  for (std::size_t i = 5; i < 10; ++i) source[i] += 10 * ms;
  const auto r = resample_means(source, 1e-3, {std::vector<double>(10, 7.0)}, false, even_stamps(24, 1 * ms, 1 * ms), 1e-3);
  EXPECT_EQ(std::accumulate(r.covered.begin(), r.covered.end(), 0), 10);
  EXPECT_EQ(r.covered[4], 1);
  EXPECT_EQ(r.covered[5], 0);
  EXPECT_EQ(r.covered[20], 0);
}

TEST(Resample, SlowQuantitiesAreInterpolated) {
  const auto r = interpolate({10 * ms, 20 * ms}, {{1, 3}}, {0, 10 * ms, 15 * ms, 20 * ms, 30 * ms});
  EXPECT_THAT(r[0], ElementsAre(1, 1, 2, 3, 3));
}

}  // namespace
}  // namespace imulab
