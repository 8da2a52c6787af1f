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

/// Rests in which the unit turns about x, alternately to either side, by `angle` of the time from the middle of a rest.
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
    for (std::size_t i = 0; i < samples + 1; ++i) {  // one between the rests
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

TEST(Stillness, OfRestsThatAreStillOnlyTheirEndsCount) {
  const Still still = rests(30, [](double) { return 0.0; });
  const Stillness s = judged(still);
  EXPECT_FALSE(s.moves);
  EXPECT_EQ(s.wander, 0);
  EXPECT_EQ(s.end, 50U);
  const Range turn = turn_between(still.recording, {0, 400}, {450, 850}, s);
  EXPECT_EQ(turn.begin, 350U);
  EXPECT_EQ(turn.end, 500U);
  EXPECT_EQ(turn_between(still.recording, {0, 60}, {100, 200}, s).begin, 30U) << "not beyond the middle";
}

TEST(Stillness, OfAHandThatSwaysIsItsAngleFromTheMiddleToTheEnds) {
  // 0.6 deg to either side about one axis is 0.35 deg over three axes. Half a second before the edge it is 0.92 of that.
  const double size = 0.6 * unit::deg;
  const Still still = rests(30, [&](double t) { return size * std::sin(t * 0.5 * 3.14159265358979 / 2); });
  const Stillness s = judged(still);
  EXPECT_NEAR(s.wander, 0.92 * size / std::sqrt(3.0), 0.05 * size);
  EXPECT_TRUE(s.moves);
  EXPECT_EQ(turn_between(still.recording, {0, 400}, {450, 850}, s).begin, 200U);
}

TEST(Stillness, TailsOfTurnsAreKnownByTheirDirectionsWhateverTheNoise) {
  // Turns of 0.1 rad with random sign have slow ends within the rests: 1 s each, a tenth of a degree. Their size resembles noise.
  for (const bool along : {true, false}) {
    Still s = rests(16, [](double) { return 0.0; });
    for (std::size_t k = 0; k < s.rests.size(); ++k) {
      const double turn = k % 3 == 0 ? 1 : -1, tail = along || k % 2 == 0 ? turn : -turn;
      Range& range = s.rests[k].range;
      range.end -= 20;
      for (std::size_t i = range.end; i < range.end + 20; ++i) s.recording.gyro[0][i] += 0.5 * turn;
      for (std::size_t i = range.end - 100; i < range.end; ++i) s.recording.gyro[0][i] += 0.1 * unit::deg * tail;
    }
    const Stillness found = stillness_of(s.recording, s.rests, SensorModel{}, Scaling{}, Vector3d::Constant(10 * noise), Vector3d::Zero());
    EXPECT_EQ(found.moves, along);
  }
}

TEST(Stillness, TheForceIsThatAtTheMiddle) {
  // The squared path has a nonzero mean of a quarter of its range.
  const double size = 0.6 * unit::deg;
  Still s = rests(3, [&](double t) { return size * (t / 2) * (t / 2); });
  EXPECT_GT(std::abs(s.rests[1].accel.y()), 0.2 * size * 9.8);
  level_at_middle(s.recording, s.rests, SensorModel{}, Scaling{});
  for (const RestMeans& rest : s.rests) EXPECT_LT(std::abs(rest.accel.y()), 0.05 * size * 9.8);
}

}  // namespace
}  // namespace imulab::rests
