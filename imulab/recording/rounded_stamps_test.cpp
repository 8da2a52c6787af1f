
#include "imulab/recording/clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace imulab {
namespace {

/// An even clock's stamps to `step_ns`, without the samples whose number `lost` divides.
std::vector<std::int64_t> rounded(double interval_ns, std::int64_t step_ns, int count, int lost = 0, double scatter_ns = 0) {
  std::vector<std::int64_t> out;
  for (int i = 1; i <= count; ++i) {
    if (lost > 0 && i % lost == 0) continue;
    const double late = scatter_ns * std::fmod(0.61803398875 * i, 1.0);
    out.push_back(std::llround((interval_ns * i + late) / static_cast<double>(step_ns)) * step_ns);
  }
  return out;
}

TEST(RoundedStamps, GiveTheIntervalOfTheirClock) {
  for (const double hz : {30.0, 400.0, 600.0, 800.0})
    for (const int lost : {0, 997}) {
      const auto found = rounded_stamps(rounded(1e9 / hz, 1'000'000, 20000, lost));
      ASSERT_TRUE(found) << hz << " " << lost;
      EXPECT_EQ(found->step_s, 1e-3);
      // Two roundings over 20000 samples, or over each stretch of 996.
      EXPECT_NEAR(found->interval_s, 1 / hz, 1e-3 / (lost > 0 ? 996 : 10000)) << hz << " " << lost;
    }
}

TEST(RoundedStamps, AreNotThoseOfOtherClocks) {
  EXPECT_FALSE(rounded_stamps(rounded(10e6, 1'000'000, 20000))) << "100 Hz in whole milliseconds";
  EXPECT_FALSE(rounded_stamps(rounded(10e6, 10'000'000, 20000, 20))) << "lost samples";
  EXPECT_FALSE(rounded_stamps(rounded(2.5e6, 1, 20000))) << "exact";
  EXPECT_FALSE(rounded_stamps(rounded(10e6, 1'000'000, 20000, 0, 8e6))) << "late by up to eight milliseconds";
  std::vector<std::int64_t> two_rates = rounded(10e6, 1'000'000, 4000);
  for (const std::int64_t stamp : rounded(11e6, 1'000'000, 4000)) two_rates.push_back(40'000'000'000 + stamp);
  EXPECT_FALSE(rounded_stamps(two_rates)) << "100 Hz, then 91 Hz";
  EXPECT_FALSE(rounded_stamps(std::vector<std::int64_t>{0, 2'000'000, 5'000'000})) << "too few to tell";
}

TEST(RoundedStamps, ShowLostSamples) {
  const std::vector<std::int64_t> stamps = rounded(2.5e6, 1'000'000, 20000, 997);
  const StampIntervals intervals = stamp_intervals(stamps);
  EXPECT_TRUE(intervals.rounded_s);
  EXPECT_TRUE(intervals.allow(2.5e-3));
  EXPECT_FALSE(intervals.allow(2e-3)) << "the usual difference";
  const std::vector<std::size_t> gaps = find_gaps(stamps, intervals.median);
  ASSERT_EQ(gaps.size(), 20U);
  for (std::size_t k = 0; k < gaps.size(); ++k) EXPECT_EQ(gaps[k], 996 * (k + 1));
}

}  // namespace
}  // namespace imulab
