#include "imulab/recording/slow_motion.hpp"

#include "imulab/core/random.hpp"
#include "imulab/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace imulab {
namespace {

/// 100 s at 100 Hz of white noise and drift; `motion`(t) is added to gyro z.
template <class Motion>
Recording log_with(const Motion& motion) {
  std::vector<std::int64_t> time_ns(10'000);
  Columns3 gyro, accel;
  const RandomStream draws(7, "slow motion");
  for (std::size_t k = 0; k < 3; ++k) gyro[k].resize(time_ns.size()), accel[k].resize(time_ns.size());
  for (std::size_t i = 0; i < time_ns.size(); ++i) {
    time_ns[i] = 10'000'000 * static_cast<std::int64_t>(i + 1);
    const double t = 0.01 * static_cast<double>(i);
    for (std::size_t k = 0; k < 3; ++k) {
      gyro[k][i] = 2e-3 * draws.normal(6 * i + k) + 1e-5 * t;
      accel[k][i] = 1e-2 * draws.normal(6 * i + 3 + k);
    }
    gyro[2][i] += motion(t);
  }
  return make_recording(Nanoseconds{std::move(time_ns)}, std::move(gyro), std::move(accel));
}

TEST(SlowMotion, NoiseAndDriftAreNone) {
  const Recording r = log_with([](double) { return 0.0; });
  EXPECT_EQ(between_slow_motion(r, {500, 9777}), (std::vector<Range>{{500, 9777}}));
}

TEST(SlowMotion, ATurnOfTenDegreesInTenSecondsIsCutWithItsEnds) {
  const Recording r = log_with([](double t) { return t < 30 || t > 40 ? 0 : 0.0175 * (1 - std::cos(0.628 * (t - 30))); });
  const std::vector<Range> parts = between_slow_motion(r, {0, 10'000});
  ASSERT_GE(parts.size(), 2u);
  EXPECT_EQ(parts.front().begin, 0u);
  EXPECT_LE(parts.front().end, 3000u);
  EXPECT_GE(parts.back().begin, 4000u);
  EXPECT_EQ(parts.back().end, 10'000u);
  EXPECT_GE(parts.front().size() + parts.back().size(), 8600u) << "no more than a block or two beside the turn";
}

TEST(SlowMotion, ReadingsThatChangeByOneStepNowAndThenRest) {
  Recording r = log_with([](double) { return 0.0; });
  for (std::size_t i = 0; i < r.size(); ++i) r.gyro[0][i] = i < 4321 ? 0 : 0.005;  // of a sensor rounded far below its noise
  EXPECT_EQ(between_slow_motion(r, {0, 10'000}).size(), 1u);
}

}  // namespace
}  // namespace imulab
