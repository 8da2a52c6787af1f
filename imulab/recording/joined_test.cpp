#include "imulab/recording/joined.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

Recording recording(const std::string& name, std::size_t size, double first) {
  Recording r;
  r.name = name;
  r.interval_s = 0.01;
  for (std::size_t i = 0; i < size; ++i) {
    r.time_ns.push_back(static_cast<std::int64_t>(1e9 * first) + static_cast<std::int64_t>(i) * 10'000'000);
    for (std::size_t axis = 0; axis < 3; ++axis) r.gyro[axis].push_back(0), r.accel[axis].push_back(static_cast<double>(i));
  }
  return r;
}

Session session_of(const std::vector<std::string>& names) {
  Session session;
  for (const std::string& name : names) {
    session.recordings.emplace_back().file = name;
    Step step;
    step.recording = name, step.start = 0.1, step.end = 0.5;
    session.steps.push_back(step);
  }
  return session;
}

TEST(Joined, AreOnOneClockWithTimeMissingBetween) {
  std::vector<Recording> both{recording("a.csv", 100, 0), recording("b.csv", 50, -7)};
  both[1].saturated = {3};
  both[1].gaps = {0, 20};
  const Joined joined = join(session_of({"a.csv", "b.csv"}), both);
  ASSERT_EQ(joined.recording.size(), 150u);
  EXPECT_EQ(joined.recording.starts, std::vector<std::size_t>{100});
  EXPECT_EQ(joined.recording.gaps, (std::vector<std::size_t>{100, 120}));
  EXPECT_EQ(joined.recording.saturated, std::vector<std::size_t>{103});
  EXPECT_GT(joined.recording.time_s(100) - joined.recording.time_s(99), 10);
  ASSERT_EQ(joined.session.steps.size(), 2u);
  // A step keeps its place among the samples of its recording.
  const double shift = joined.recording.time_s(100) - both[1].time_s(0);
  EXPECT_NEAR(joined.session.steps[1].start, 0.1 + shift, 1e-9);
  EXPECT_EQ(joined.session.steps[1].recording, "a.csv");
  EXPECT_EQ(joined.session.recordings.size(), 1u);
  EXPECT_EQ(part_at(joined.parts, joined.recording.time_s(99)).name, "a.csv");
  EXPECT_EQ(part_at(joined.parts, joined.recording.time_s(100)).name, "b.csv");
  EXPECT_NEAR(joined.recording.time_s(120) - part_at(joined.parts, joined.recording.time_s(120)).shift_s, both[1].time_s(20), 1e-6);
}

TEST(Joined, AreOfOneFormAndRate) {
  std::vector<Recording> both{recording("a.csv", 100, 0), recording("b.csv", 50, 0)};
  both[1].interval_s = 0.02;
  EXPECT_THAT([&] { join(session_of({"a.csv", "b.csv"}), both); }, testing::ThrowsMessage<Error>(testing::HasSubstr("b.csv have different rates")));
  both[1].interval_s = 0.01, both[1].accel_unit = "m/s^2";
  EXPECT_THAT([&] { join(session_of({"a.csv", "b.csv"}), both); }, testing::ThrowsMessage<Error>(testing::HasSubstr("different units")));
}

}  // namespace
}  // namespace imulab
