// Lost samples between kept ones: a smooth motion is restored, everything else stays as it is.
#include "imulab/recording/readings.hpp"
#include "imulab/recording/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

constexpr double interval = 0.01, frequency = 2;

double motion(double t) { return std::sin(2 * std::numbers::pi * frequency * t); }

/// 100 Hz of a motion of 2 Hz without the samples of which `lost` is true.
template <class Lost>
Recording recording_without(std::size_t samples, Lost lost) {
  Recording r;
  r.interval_s = interval;
  for (std::size_t i = 0; i < samples; ++i) {
    if (lost(i)) continue;
    if (!r.time_ns.empty() && r.time_ns.back() != static_cast<std::int64_t>(i - 1) * 10'000'000) r.gaps.push_back(r.time_ns.size());
    r.time_ns.push_back(static_cast<std::int64_t>(i) * 10'000'000);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      r.gyro[axis].push_back(motion(interval * static_cast<double>(i)));
      r.accel[axis].push_back(static_cast<double>(axis) + 1);
    }
  }
  return r;
}

TEST(ShortGaps, AreFilledAsTheMotionGoesOn) {
  const Recording r = recording_without(400, [](std::size_t i) { return i % 50 == 20 || i % 50 == 40 || i % 50 == 41; });
  const FilledRecording filled = with_short_gaps_filled(r);
  EXPECT_EQ(filled.filled, 24u);
  ASSERT_EQ(filled.recording.size(), 400u);
  EXPECT_TRUE(filled.recording.gaps.empty());
  const double two_lost = std::pow(2 * std::numbers::pi * frequency * interval, 4) / 2;  // f'''' / 4! times |(x + 1) x (x - 3) (x - 4)| = 12 at x = 1
  for (std::size_t i = 0; i < 400; ++i) {
    EXPECT_EQ(filled.recording.time_ns[i], static_cast<std::int64_t>(i) * 10'000'000);
    EXPECT_NEAR(filled.recording.gyro[1][i], motion(interval * static_cast<double>(i)), two_lost) << i;
    EXPECT_NEAR(filled.recording.accel[2][i], 3, 1e-12);  // a constant is exact but for rounding
  }
}

TEST(ShortGaps, LongOnesStay) {
  const Recording r = recording_without(400, [](std::size_t i) { return (i >= 100 && i < 103) || i == 200; });
  const FilledRecording filled = with_short_gaps_filled(r);
  EXPECT_EQ(filled.filled, 1u);
  ASSERT_EQ(filled.recording.gaps.size(), 1u);
  EXPECT_EQ(filled.recording.gaps[0], 100u);
}

TEST(ShortGaps, SaturatedNeighborsSupportNothing) {
  Recording r = recording_without(400, [](std::size_t i) { return i == 100 || i == 200; });
  r.saturated = {101, 300};
  const FilledRecording filled = with_short_gaps_filled(r);
  EXPECT_EQ(filled.filled, 1u);
  EXPECT_EQ(filled.recording.saturated, (std::vector<std::size_t>{101, 301}));  // the same samples, one of them after the filled one
}

TEST(ShortGaps, ManyAreNotInvented) {
  const Recording r = recording_without(400, [](std::size_t i) { return i % 5 == 3; });
  EXPECT_EQ(with_short_gaps_filled(r).filled, 0u);
}

}  // namespace
}  // namespace imulab
