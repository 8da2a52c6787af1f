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

/// A phone's accelerometer in steps far above its noise: most of its readings are those of rests, the outermost ones, too.
TEST(Clipping, CoarseReadingsAtRestAreAtNoLimit) {
  std::vector<double> channel;
  const auto add = [&](double value) { channel.push_back(0.1 * std::round(10 * value)); };
  const auto rest = [&](double value, int samples) {
    for (int i = 0; i < samples; ++i) add(value);
  };
  const auto turn = [&](double from, double to, int samples = 50) {
    for (int i = 1; i < samples; ++i) add(from + (to - from) * 0.5 * (1 - std::cos(3.14159265358979 * i / samples)));
  };
  rest(10.1, 500), turn(10.1, -0.2), rest(-0.2, 100), turn(-0.2, 6.9), rest(6.9, 30), turn(6.9, -0.2), rest(-0.2, 425);
  EXPECT_TRUE(clipped_samples(channel).empty());
  for (int k = 0; k < 3; ++k) turn(-0.2, 9.9, 20), rest(9.9, 60), turn(9.9, -0.2, 20), rest(-0.2, 60);
  for (double& v : channel) v = std::min(v, 5.0);  // cut off in the turns
  EXPECT_FALSE(clipped_samples(channel).empty());
}

TEST(Clipping, AStuckChannelDoesNotClip) { EXPECT_TRUE(clipped_samples(std::vector<double>(1000, 3.0)).empty()); }

}  // namespace
}  // namespace imulab
