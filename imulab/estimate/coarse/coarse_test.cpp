#include "imulab/estimate/coarse/coarse.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace imulab::coarse {
namespace {

Vector3d random_direction(std::uint64_t i) {
  const RandomStream draws(1, "directions");
  return Vector3d(draws.normal(3 * i), draws.normal(3 * i + 1), draws.normal(3 * i + 2)).normalized();
}

const double g = 9.80665;

struct Accel {
  Vector3d offset{0.3, -0.2, 0.1};
  Matrix3d matrix = (Matrix3d() << 1.02, 0, 0, 0.015, 0.97, 0, -0.02, 0.01, 1.03).finished();
  Vector3d reading(const Vector3d& up) const { return matrix.inverse() * (g * up - offset); }
};

TEST(Coarse, AccelerometersFromExactRests) {
  const Accel truth;
  std::vector<Vector3d> readings;
  for (std::uint64_t i = 0; i < 12; ++i) readings.push_back(truth.reading(random_direction(i)));
  const auto found = coarse_accel(readings, g);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->misalignment);
  EXPECT_LT((found->matrix - truth.matrix).norm(), 1e-11);
  EXPECT_LT((found->offset - truth.offset).norm(), 1e-10);
}

TEST(Coarse, SixFacesLeaveMisalignmentOpen) {
  const Accel truth;
  std::vector<Vector3d> readings;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) readings.push_back(truth.reading(sign * Vector3d::Unit(axis)));
  const auto found = coarse_accel(readings, g);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->misalignment);
  // A misalignment of 2 % that is set to zero causes second-order errors in the scales.
  EXPECT_LT((found->matrix.diagonal() - truth.matrix.diagonal()).norm(), 2e-3);
  EXPECT_LT((found->offset - truth.offset).norm(), 1e-2);
}

TEST(Coarse, RestsOnOneAxisGiveNothing) {
  std::vector<Vector3d> readings;
  for (int i = 0; i < 12; ++i) readings.push_back(Accel{}.reading((i % 2 == 0 ? 1.0 : -1.0) * Vector3d::UnitZ()));
  EXPECT_FALSE(coarse_accel(readings, g));
}

TEST(Coarse, GyrosFromEarthRate) {
  const double latitude = 0.7;
  Matrix3d matrix;
  matrix << 1.01, 0.02, -0.01, 0.005, 0.98, 0.01, 0.015, -0.02, 1.02;
  const Vector3d offset(1e-5, -2e-5, 3e-5);
  std::vector<RestMeans> rests(20);
  for (std::uint64_t i = 0; i < rests.size(); ++i) {
    const Vector3d up = random_direction(i), side = random_direction(100 + i);
    const Vector3d north = (side - side.dot(up) * up).normalized();
    const Vector3d rate = earth_rate * (std::sin(latitude) * up + std::cos(latitude) * north);
    rests[i].accel = g * up;
    rests[i].gyro = matrix.inverse() * (rate - offset);
  }
  const auto found = coarse_gyro_at_rest(rests, {}, {}, earth_rate * std::sin(latitude));
  ASSERT_TRUE(found);
  EXPECT_LT((found->matrix - matrix).norm(), 1e-9);
  EXPECT_LT((found->offset - offset).norm(), 1e-13);
  EXPECT_FALSE(coarse_gyro_at_rest(rests, {}, {}, 0)) << "at the equator the scale is lost";
  rests.resize(11);
  EXPECT_FALSE(coarse_gyro_at_rest(rests, {}, {}, earth_rate * std::sin(latitude))) << "twelve unknowns need twelve rests";
}

TEST(Coarse, GyrosInMotionEndWhateverTheIntervalIs) {
  Recording recording;
  recording.time_ns.resize(40);
  for (Columns3* triad : {&recording.gyro, &recording.accel})
    for (auto& column : *triad) column.assign(40, 1);
  recording.interval_s = 0;
  EXPECT_FALSE(coarse_gyro_in_motion(recording, summarize_rests(recording, {{0, 10}, {30, 40}}), {}, {}));
}

TEST(Coarse, GyrosInMotionTakeNothingBeyondTheRecording) {
  // 20 s of motion about all axes at 1 kHz; gravity is averaged over 1/8 s, and the first and last rests last 1/100 s.
  constexpr std::size_t n = 20'000, rest = 10;
  Recording recording;
  recording.interval_s = 1e-3;
  Vector3d up(0.6, 0, 0.8);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = recording.interval_s * static_cast<double>(i);
    const Vector3d rate =
        i < rest || i >= n - rest ? Vector3d::Zero() : Vector3d(2 * std::sin(1.3 * t), 2 * std::cos(0.9 * t), 2 * std::sin(0.5 * t + 1));
    up = rotation_exp(Vector3d(-recording.interval_s * rate)) * up;
    recording.time_ns.push_back(static_cast<std::int64_t>(i) * 1'000'000);
    for (Eigen::Index j = 0; j < 3; ++j) {
      recording.gyro[static_cast<std::size_t>(j)].push_back(rate[j]);
      recording.accel[static_cast<std::size_t>(j)].push_back(g * up[j]);
    }
  }
  const auto found = coarse_gyro_in_motion(recording, summarize_rests(recording, {{0, rest}, {n - rest, n}}), {}, {});
  ASSERT_TRUE(found);
  EXPECT_LT((*found - Matrix3d::Identity()).norm(), 0.1) << "good to some percent";
}

}  // namespace
}  // namespace imulab::coarse
