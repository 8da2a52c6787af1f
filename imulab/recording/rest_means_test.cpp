#include "imulab/recording/rest_means.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

TEST(RestMeans, MeansAndNoiseOfCountsFarFromZero) {
  Recording r;
  r.interval_s = 0.01;
  for (int i = 0; i < 400; ++i) {
    r.time_ns.push_back(10'000'000LL * (i + 1));
    for (std::size_t j = 0; j < 3; ++j) {
      r.gyro[j].push_back(1e9 + (i % 2 == 0 ? 1 : -1));
      r.accel[j].push_back(2e9 + static_cast<double>(j) + (i % 2 == 0 ? 3 : -3));
    }
  }
  const auto rests = summarize_rests(r, {{0, 200}, {200, 400}});
  EXPECT_EQ(rests[1].gyro, Vector3d::Constant(1e9));
  EXPECT_EQ(rests[0].accel, Vector3d(2e9, 2e9 + 1, 2e9 + 2));
  EXPECT_DOUBLE_EQ(rests[1].mid_s, 3.005);
  const SampleNoise noise = measure_noise(r, rests);
  EXPECT_NEAR(noise.gyro.x(), std::sqrt(400.0 / 398), 1e-12);
  EXPECT_NEAR(noise.accel.z(), 3 * std::sqrt(400.0 / 398), 1e-12);
}

}  // namespace
}  // namespace imulab
