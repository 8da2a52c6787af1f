#include "imulab/estimate/rests/stillness.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace imulab::rests {
namespace {

constexpr double noise = 1e-3, interval = 0.01;  // rad/s, s
constexpr std::size_t samples = 400;

/// Rests at which the unit turns about x, to one side and the other in turn, by `angle` of the time from a rest's middle.
struct Still {
  Recording recording;
  std::vector<RestMeans> rests;
};

Still rests(int count, const std::function<double(double)>& turned) {
  Still out;
  out.recording.interval_s = interval;
  const RandomStream random(3, "stillness");
  std::uint64_t draw = 0;
  std::vector<Range> ranges;
  for (int k = 0; k < count; ++k) {
    ranges.push_back({out.recording.size(), out.recording.size() + samples});
    const auto angle = [&](double t) { return k % 2 == 0 ? turned(t) : -turned(t); };
    for (std::size_t i = 0; i < samples; ++i) {
      const double end = (static_cast<double>(i) + 1 - samples / 2.0) * interval, begin = end - interval, middle = angle(0.5 * (begin + end));
      out.recording.time_ns.push_back(static_cast<std::int64_t>(out.recording.time_ns.size() + 1) * 10'000'000);
      const Vector3d force = rotation_exp(Vector3d(-middle, 0, 0)) * Vector3d(0, 0, 9.8);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.recording.gyro[axis].push_back(noise * random.normal(draw++) + (axis == 0 ? (angle(end) - angle(begin)) / interval : 0));
        out.recording.accel[axis].push_back(force[static_cast<Eigen::Index>(axis)]);
      }
    }
  }
  out.rests = summarize_rests(out.recording, ranges);
  return out;
}

Stillness judged(const Still& s) { return stillness_of(s.recording, s.rests, SensorModel{}, Scaling{}, Vector3d::Constant(noise), Vector3d::Zero()); }

TEST(Stillness, OfRestsThatAreStillNoWeightOfTheGyros) {
  const Stillness s = judged(rests(30, [](double) { return 0.0; }));
  EXPECT_EQ(s.wander, 0);
  EXPECT_EQ(s.weight(), 0);
  const double half = 0.5 * samples * interval;  // s
  EXPECT_NEAR(s.noise, std::hypot(noise * std::sqrt(half * interval), earth_rate * half / std::sqrt(3.0)), 1e-9);
}

TEST(Stillness, OfAHandThatSwaysIsItsAngleFromTheMiddleToTheEdges) {
  // 0.6 deg to either side about one axis: 0.35 deg over three axes.
  const double size = 0.6 * unit::deg;
  const Stillness s = judged(rests(30, [&](double t) { return size * std::sin(t * 0.5 * 3.14159265358979 / 2); }));
  EXPECT_NEAR(s.wander, size / std::sqrt(3.0), 0.05 * size);
  EXPECT_GT(s.weight(), 0.99);
}

TEST(Stillness, TheForceIsThatAtTheMiddle) {
  // A quarter of the way's square: its mean is not zero.
  const double size = 0.6 * unit::deg;
  Still s = rests(3, [&](double t) { return size * (t / 2) * (t / 2); });
  EXPECT_GT(std::abs(s.rests[1].accel.y()), 0.2 * size * 9.8);
  level_at_middle(s.recording, s.rests, 1, SensorModel{}, Scaling{});
  for (const RestMeans& rest : s.rests) EXPECT_LT(std::abs(rest.accel.y()), 0.05 * size * 9.8);
}

}  // namespace
}  // namespace imulab::rests
