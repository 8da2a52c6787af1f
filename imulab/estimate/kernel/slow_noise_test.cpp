#include "imulab/estimate/kernel/slow_noise.hpp"

#include "imulab/model/sensor_noise.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace imulab::kernel {
namespace {

TEST(SlowNoise, CovarianceOfMeansIsThatOfDraws) {
  const std::vector<TimeSpan> times{{0, 20}, {20, 30}, {70, 100}};
  NoiseModel noise;
  noise.B = 1, noise.K = 0.1, noise.R = {0.02};
  constexpr int draws = 4000;
  Eigen::Matrix3d drawn = Eigen::Matrix3d::Zero();
  for (int k = 0; k < draws; ++k) {
    std::vector<double> slow(100, 0.0);  // at 1 Hz
    AxisNoise(noise, 1, 1, fmt::format("draw {}", k)).add_slow(slow);
    Eigen::Vector3d mean;
    for (std::size_t i = 0; i < 3; ++i)
      mean[static_cast<Eigen::Index>(i)] =
          std::accumulate(slow.begin() + static_cast<long>(times[i].begin), slow.begin() + static_cast<long>(times[i].end), 0.0) /
          (times[i].end - times[i].begin);
    drawn += mean * mean.transpose() / draws;
  }
  const Eigen::MatrixXd expected = slow_noise(times, noise, 1);
  // The sampled covariance scatters by at most sqrt(2 / draws) of the variances; cells are accurate to a few percent of flicker.
  const double scale = expected.diagonal().maxCoeff();
  EXPECT_LT((drawn - expected).cwiseAbs().maxCoeff(), (4.5 * std::sqrt(2.0 / draws) + 0.02) * scale) << drawn << "\n\n" << expected;
  EXPECT_EQ(slow_noise(times, {.N = 1}, 1).size(), 0);
}

}  // namespace
}  // namespace imulab::kernel
