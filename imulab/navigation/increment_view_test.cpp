#include "imulab/navigation/increment_view.hpp"

#include "imulab/core/random.hpp"
#include "imulab/navigation/inertial_samples.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

// Tests rates and increments, with gaps of less than a sample, of several samples, and adjacent gaps.
TEST(IncrementView, IsTheSamplesInTheirOrder) {
  const RandomStream draw(1, "view");
  for (const bool increments : {false, true}) {
    Recording r;
    r.interval_s = 0.01, r.gyro_increment = increments;
    std::int64_t time = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
      const bool gap = i == 50 || i == 51 || i == 120;
      if (gap) r.gaps.push_back(i);
      r.time_ns.push_back(time += gap ? (i == 51 ? 14'000'000 : 83'000'000) : 10'000'000);
      for (std::uint64_t k = 0; k < 3; ++k) r.gyro[k].push_back(draw.normal(6 * i + k)), r.accel[k].push_back(draw.normal(6 * i + 3 + k));
    }
    const InertialSamples all = inertial_samples(r, {0, r.size()});
    const IncrementView view(r);
    ASSERT_EQ(view.size(), all.steps.size());
    EXPECT_GT(view.size(), r.size() + 10);
    for (std::size_t i = 0; i < view.size(); ++i) {
      EXPECT_EQ(view[i].increment.angle, all.steps[i].increment.angle) << i;
      EXPECT_EQ(view[i].increment.velocity, all.steps[i].increment.velocity) << i;
      EXPECT_EQ(view[i].interval, all.steps[i].interval) << i;
    }
  }
}

}  // namespace
}  // namespace imulab
