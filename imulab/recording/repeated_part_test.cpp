#include "imulab/recording/repeated_part.hpp"

#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

Recording noise(std::size_t samples, double step) {
  const RandomStream random(1, "repeated");
  Recording r;
  r.interval_s = 0.01;
  for (std::size_t i = 0; i < samples; ++i) r.time_ns.push_back(static_cast<std::int64_t>(i + 1) * 10'000'000);
  std::uint64_t draw = 0;
  for (Columns3* triad : {&r.gyro, &r.accel})
    for (std::vector<double>& column : *triad)
      for (std::size_t i = 0; i < samples; ++i) column.push_back(step * std::round(random.normal(draw++) / step));
  return r;
}

void copy(const Recording& from, std::size_t begin, std::size_t size, Recording& to, std::size_t at) {
  for (Columns3 Recording::*triad : {&Recording::gyro, &Recording::accel})
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < size; ++i) (to.*triad)[axis][at + i] = (from.*triad)[axis][begin + i];
}

TEST(RepeatedPart, IsFoundWhereverItStands) {
  for (const std::size_t at : {1000UL, 1037UL, 4801UL}) {
    Recording r = noise(5000, 0.01);
    copy(r, 333, 199, r, at);
    const auto found = repeated_part({&r, 1});
    ASSERT_TRUE(found) << at;
    EXPECT_EQ(found->samples, (Range{at, at + 199}));
    EXPECT_EQ(found->earlier, (Range{333, 333 + 199}));
    EXPECT_EQ(found->in_all, 199U);
  }
}

TEST(RepeatedPart, OfAnotherRecordingIsFound) {
  std::vector<Recording> both{noise(3000, 0.01), noise(4000, 0.01)};  // the second has other readings: its columns are drawn after each other
  EXPECT_FALSE(repeated_part({both.data() + 1, 1}));
  copy(both[0], 500, 1000, both[1], 2000);
  const auto found = repeated_part(both);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->recording, 1U);
  EXPECT_EQ(found->of, 0U);
  EXPECT_EQ(found->samples.end, 3000U);
}

/// At a step of three standard deviations one row in five is like the one before, at five, six of seven are.
TEST(RepeatedPart, CoarseReadingsAreNone) {
  for (const double step : {1.0, 2.0, 3.0, 5.0, 20.0}) {
    const Recording r = noise(200'000, step);
    EXPECT_FALSE(repeated_part({&r, 1})) << step;
  }
}

/// Four readings in turn are no repetition, and take no longer than any others.
TEST(RepeatedPart, APatternIsNone) {
  const Recording four = noise(4, 0.01);
  Recording r = noise(400'000, 0.01);
  for (std::size_t i = 100'000; i < r.size(); i += 4) copy(four, 0, 4, r, i);
  EXPECT_FALSE(repeated_part({&r, 1}));
}

TEST(RepeatedPart, TheWholeFileFiveTimesCountsFourTimes) {
  const Recording once = noise(2000, 0.01);
  Recording r = noise(10'000, 0.01);
  for (std::size_t k = 0; k < 5; ++k) copy(once, 0, 2000, r, 2000 * k);
  const auto found = repeated_part({&r, 1});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->in_all, 8000U);
}

}  // namespace
}  // namespace imulab
