#include "imulab/recording/repeated_rows.hpp"

#include "imulab/core/random.hpp"
#include "imulab/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace imulab {
namespace {

/// Noise of one standard deviation and so large a step; row i is sample `of`(i) of the sensor.
Recording rows_of(std::size_t rows, double step, const std::function<std::size_t(std::size_t)>& of) {
  std::vector<double> t(rows);
  Columns3 gyro, accel;
  for (std::size_t c = 0; c < 6; ++c) {
    const RandomStream noise(3, static_cast<std::uint64_t>(c));
    std::vector<double>& column = (c < 3 ? gyro : accel)[c % 3];
    for (std::size_t i = 0; i < rows; ++i) column.push_back(1e-3 * step * std::round(noise.normal(of(i)) / step) + (c == 5 ? 9.8 : 0));
  }
  for (std::size_t i = 0; i < rows; ++i) t[i] = 0.01 * static_cast<double>(i + 1);
  return make_recording(t, std::move(gyro), std::move(accel));
}

/// Sample of the sensor by row where so many rows in a thousand, at random, repeat the one before.
std::function<std::size_t(std::size_t)> frozen(std::size_t rows, double share) {
  std::vector<std::size_t> of(rows);
  const RandomStream chance(5, "frozen");
  for (std::size_t i = 1; i < rows; ++i) of[i] = chance.uniform(i) < share ? of[i - 1] : i;
  return [of](std::size_t i) { return of[i]; };
}

TEST(RepeatedRows, AreFoundAtAnyShare) {
  constexpr std::size_t rows = 8'000;
  for (const double share : {0.01, 0.15, 0.5, 0.8}) {
    const Recording r = rows_of(rows, 0.05, frozen(rows, share));
    const auto found = repeated_rows(r, 0, 6);
    ASSERT_TRUE(found) << share;
    EXPECT_NEAR(found->share, share, 0.02);
    EXPECT_FALSE(found->evenly) << share;
    EXPECT_EQ(without_samples(r, *found).size(), rows - found->samples.size());
  }
}

TEST(RepeatedRows, OfASlowSensorComeEvenly) {
  const Recording r = rows_of(8'000, 0.05, [](std::size_t i) { return static_cast<std::size_t>(0.63 * static_cast<double>(i)); });
  const auto found = repeated_rows(r, 0, 6);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->evenly);
  const Recording slow = without_samples(r, *found);
  EXPECT_NEAR(1e-9 * static_cast<double>(slow.time_ns[3001] - slow.time_ns[3000]), 0.01 / 0.63, 1e-5);
}

TEST(RepeatedRows, WithoutThemARecordingStaysAsItIs) {
  const Recording r = rows_of(1'000, 0.05, [](std::size_t i) { return i; });
  const Recording same = without_samples(r, {});
  EXPECT_EQ(same.time_ns, r.time_ns);
  EXPECT_EQ(same.gyro, r.gyro);
  EXPECT_EQ(same.accel, r.accel);
}

TEST(RepeatedRows, OfCoarseReadingsAreChance) {
  for (const double step : {0.5, 2.0, 4.0, 8.0}) {
    const Recording r = rows_of(8'000, step, [](std::size_t i) { return i; });
    EXPECT_FALSE(repeated_rows(r, 0, 6)) << step;
    EXPECT_FALSE(repeated_rows(r, 3, 6)) << step;
  }
  const auto found = repeated_rows(rows_of(8'000, 2, frozen(8'000, 0.2)), 0, 6);
  ASSERT_TRUE(found) << "more than chance";
  EXPECT_NEAR(found->share, 0.2, 0.08);
}

TEST(RepeatedRows, OfAnImuWithoutNoiseAtRestAreNone) {
  const Recording r = rows_of(8'000, 0.05, [](std::size_t i) { return i / 1000 % 2 == 0 ? i / 1000 * 1000 : i; });
  EXPECT_FALSE(repeated_rows(r, 0, 6));
}

}  // namespace
}  // namespace imulab
