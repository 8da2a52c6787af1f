#include "imulab/recording/clipping.hpp"

#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

/// A swinging sensor with noise, in steps of `step` (0: none).
std::vector<double> swing(double noise, double step, std::uint64_t seed) {
  const RandomStream random(seed, "clipping");
  std::vector<double> channel;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const double x = 10 * std::sin(1e-3 * static_cast<double>(i)) + noise * random.normal(i);
    channel.push_back(step > 0 ? step * std::round(x / step) : x);
  }
  return channel;
}

TEST(Clipping, IsNotSeenInGoodReadings) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const double step : {0.0, 0.001, 0.01, 0.1, 1.0}) EXPECT_TRUE(clipped_samples(swing(0.02, step, seed)).empty()) << seed << " " << step;
}

TEST(Clipping, FindsTheSamplesAtALimit) {
  for (const double step : {0.0, 0.001, 0.01}) {
    std::vector<double> channel = swing(0.02, step, 1);
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < channel.size(); ++i) {
      channel[i] = std::clamp(channel[i], -9.5, 9.0);
      if (channel[i] == -9.5 || channel[i] == 9.0) expected.push_back(i);
    }
    EXPECT_EQ(clipped_samples(channel), expected) << step;
  }
}

TEST(Clipping, FindsALimitThatOnlyNoiseReaches) {
  std::vector<double> channel = swing(0.02, 0, 1);
  std::fill(channel.begin() + 5000, channel.begin() + 8000, 0);  // at rest on the limit
  const RandomStream random(2, "clipping");
  for (std::size_t i = 5000; i < 8000; ++i) channel[i] = std::min(10.1, 10.1 + 0.02 * random.normal(i));
  const std::vector<std::size_t> found = clipped_samples(channel);
  EXPECT_GT(found.size(), 1300u);  // half of 3000, give or take four sigma
  EXPECT_LT(found.size(), 1700u);
}

/// A table without noise: one axis stays down through several rests and turns about it, longer than in any other attitude.
TEST(Clipping, AnAxisThatStaysDownDoesNotClip) {
  std::vector<double> channel;
  const auto hold = [&](double value, int samples) { channel.insert(channel.end(), static_cast<std::size_t>(samples), value); };
  const auto turn = [&](double from, double to) {
    for (int i = 1; i < 900; ++i) channel.push_back(1e-6 * std::round(1e6 * (from + (to - from) * i / 900)));
  };
  hold(0.1, 6000), turn(0.1, -9.8), hold(-9.8, 50000), turn(-9.8, 0.1), hold(0.1, 6000), turn(0.1, 9.8), hold(9.8, 6000);
  EXPECT_TRUE(clipped_samples(channel).empty());
}

TEST(Clipping, AStuckChannelDoesNotClip) { EXPECT_TRUE(clipped_samples(std::vector<double>(1000, 3.0)).empty()); }

}  // namespace
}  // namespace imulab
