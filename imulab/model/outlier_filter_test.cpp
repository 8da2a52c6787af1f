#include "imulab/outlier_filter.hpp"

#include "imulab/core/random.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {
namespace {

using ::testing::Each;

using Six = std::array<std::vector<double>, 6>;

std::array<std::span<double>, 6> spans(Six& columns) { return {columns[0], columns[1], columns[2], columns[3], columns[4], columns[5]}; }

Six noise(std::size_t n, double sigma = 1) {
  Six columns;
  for (std::size_t c = 0; c < 6; ++c) {
    columns[c].resize(n);
    RandomStream(7, 40 + c).normals(0, columns[c]);
    for (double& x : columns[c]) x *= sigma;
  }
  return columns;
}

constexpr std::size_t learned = 150;  // 64 windows are used of these: four in five of white noise are

TEST(OutlierFilter, WhiteNoiseGivesFewerThanOneFalseAlarmInAMillion) {
  Six columns = noise(1'666'667);  // ten million readings
  const auto replaced = reject_outliers(spans(columns));
  int alarms = 0;
  for (const std::uint8_t mask : replaced) alarms += __builtin_popcount(mask);
  EXPECT_LE(alarms, 2);  // none in 1e9 readings of other draws: a rate below 3e-9 with 95 % confidence
}

/// Adds spikes of `size` with alternating signs, `together` in a row, to `signal`, which changes by at most `slope` per sample. Expects that all are
/// found and nothing else except, on a slope, samples within two of them; and that the output is the signal.
void expect_all_found(const std::vector<double>& signal, double sigma, double size, std::size_t together, double slope) {
  const std::size_t n = signal.size();
  Six columns = noise(n, sigma);
  for (auto& column : columns)
    for (std::size_t i = 0; i < n; ++i) column[i] += signal[i];
  std::vector<bool> spike(n), near(n);
  for (std::size_t i = learned, k = 0; i + 10 < n; i += 53, ++k) {
    for (std::size_t j = i; j < i + together; ++j) {
      for (auto& column : columns) column[j] += k % 2 ? -size : size;
      spike[j] = true;
    }
    for (std::size_t j = i - 2; j < i + together + 2; ++j) near[j] = slope > 0;
  }
  const auto replaced = reject_outliers(spans(columns));
  for (std::size_t i = 0; i < n; ++i) {
    if (spike[i] || !near[i]) {
      ASSERT_EQ(replaced[i], spike[i] ? 63 : 0) << i;
    }
    // Six sigma: none of 120,000 readings exceeds it (p = 2e-4). The middle of two of four neighbors is at most one and a half samples away.
    for (const auto& column : columns) ASSERT_NEAR(column[i], signal[i], 6 * sigma + 1.5 * slope) << i;
  }
}

TEST(OutlierFilter, FindsEverySpikeOf25SigmaAndEveryPairOf75) {
  const std::vector<double> rest(20'000, 3.0);
  expect_all_found(rest, 0.1, 2.5, 1, 0);
  expect_all_found(rest, 0.1, 7.5, 2, 0);  // for a pair, the cubic through the neighbors leaves a third
}

TEST(OutlierFilter, FindsEverySpikeInARollOf400DegPerSecondWithRamps) {
  constexpr double rate_hz = 50, sigma = 0.14, acceleration = 1000;  // deg/s from 0.02 deg/s/sqrt(Hz), deg/s^2
  std::vector<double> roll;
  for (std::size_t i = 0; i < 20'000; ++i) {  // up in 0.4 s, 1.6 s of rolling, down; 3 s at rest in between
    const double t = std::fmod(static_cast<double>(i) / rate_hz, 5.4);
    roll.push_back(std::clamp(std::min((t - 3) * acceleration, (5.4 - t) * acceleration), 0.0, 400.0));
  }
  const double slope = acceleration / rate_hz;
  expect_all_found(roll, sigma, 25 * sigma + slope, 1, slope);
}

TEST(OutlierFilter, AMonotoneSignalPassesUnchanged) {
  EXPECT_TRUE(rc::check([] {
    const double sign = *rc::gen::element(-1.0, 1.0);
    double value = 0;
    Six columns;
    for (int i = 0; i < 200; ++i) {
      const int kind = *rc::gen::inRange(0, 4);  // constant, slow change, step, jump
      value += kind == 0 ? 0.0 : std::pow(10.0, *rc::gen::inRange(-6, 9) * (kind == 3)) * (kind == 1 ? 1e-3 : 1);
      for (auto& column : columns) column.push_back(sign * value);
    }
    const Six before = columns;
    RC_ASSERT(reject_outliers(spans(columns)) == std::vector<std::uint8_t>(200, 0));
    RC_ASSERT(columns == before);
  }));
}

TEST(OutlierFilter, StepsAndSmoothMotionPass) {
  Six columns = noise(4000);
  for (std::size_t i = 0; i < 4000; ++i) {
    for (std::size_t c = 0; c < 3; ++c) columns[c][i] += i / 500 % 2 ? 1000 : 0;
    for (std::size_t c = 3; c < 6; ++c) columns[c][i] += 300 * std::sin(0.1 * 3.14159 * static_cast<double>(i));  // a twentieth of the sampling rate
  }
  const Six before = columns;
  EXPECT_THAT(reject_outliers(spans(columns)), Each(0));
  EXPECT_EQ(columns, before);
}

TEST(OutlierFilter, AfterASlopeTheNoiseIsStillKnown) {
  Six columns = noise(3000);
  for (auto& column : columns)
    for (std::size_t i = 500; i < column.size(); ++i) column[i] += 100.0 * static_cast<double>(std::min<std::size_t>(i, 2500) - 500);
  EXPECT_THAT(reject_outliers(spans(columns)), Each(0));
}

TEST(OutlierFilter, TheFlickerOfRoundedReadingsIsNoOutlier) {
  Six columns = noise(20'000, 0.2);  // in steps: one reading in eighty is not the usual one
  for (auto& column : columns) {
    for (double& x : column) x = 0.25 * std::round(x);
    column[10'000] += 20 * 0.25;
  }
  const auto replaced = reject_outliers(spans(columns));
  for (std::size_t i = 0; i < replaced.size(); ++i) EXPECT_EQ(replaced[i], i == 10'000 ? 63 : 0) << i;
}

TEST(OutlierFilter, ThreeTogetherPass) {  // a documented limit: they may be a pulse
  Six columns = noise(1000);
  for (auto& column : columns)
    for (std::size_t i = 500; i < 503; ++i) column[i] += 1000;
  EXPECT_THAT(reject_outliers(spans(columns)), Each(0));
}

TEST(OutlierFilter, AVibrationThatSetsInIsLearned) {  // a documented limit: its first samples are treated as outliers
  Six columns = noise(3000);
  for (auto& column : columns)
    for (std::size_t i = 1000; i < column.size(); ++i) column[i] *= 100;
  const auto replaced = reject_outliers(spans(columns));
  for (std::size_t c = 0; c < 6; ++c) {
    const auto count = std::count_if(replaced.begin(), replaced.end(), [c](std::uint8_t mask) { return mask >> c & 1; });
    EXPECT_GT(count, 5);
    EXPECT_LT(count, 60);  // s grows by at most 9 % per sample, and 1.09^35 = 20 makes K s of the old noise twice the new sigma
  }
  EXPECT_TRUE(std::all_of(replaced.begin() + 1200, replaced.end(), [](std::uint8_t mask) { return mask == 0; }));
}

TEST(OutlierFilter, GivesEachSampleTwoLaterAndTheLastTwoAtTheEnd) {
  for (std::size_t n = 0; n < 9; ++n) {
    OutlierFilter filter;
    std::size_t given = 0;
    const auto expect_next = [&](const std::optional<OutlierFilter::Output>& out) {
      ASSERT_TRUE(out.has_value());
      EXPECT_EQ(out->readings, (OutlierFilter::Readings{static_cast<double>(given), 1, 2, 3, 4, 5}));
      EXPECT_EQ(out->replaced, 0);
      ++given;
    };
    for (std::size_t i = 0; i < n; ++i) {
      const auto out = filter.push({static_cast<double>(i), 1, 2, 3, 4, 5});
      if (i < OutlierFilter::delay) {
        EXPECT_FALSE(out.has_value());
      } else {
        expect_next(out);
      }
    }
    while (given < n) expect_next(filter.rest());
    EXPECT_FALSE(filter.rest().has_value());
  }
}

TEST(OutlierFilter, ColumnsAreTheSameBitForBit) {
  Six columns = noise(5000);
  for (std::size_t i = 200; i < 4990; i += 11) columns[i % 6][i] += 60;
  const Six raw = columns;
  const auto replaced = reject_outliers(spans(columns));
  OutlierFilter filter;
  std::size_t at = 0, count = 0;
  const auto expect_same = [&](const OutlierFilter::Output& out) {
    for (std::size_t c = 0; c < 6; ++c) ASSERT_EQ(out.readings[c], columns[c][at]);
    ASSERT_EQ(out.replaced, replaced[at++]);
    count += out.replaced != 0;
  };
  for (std::size_t i = 0; i < 5000; ++i)
    if (const auto out = filter.push({raw[0][i], raw[1][i], raw[2][i], raw[3][i], raw[4][i], raw[5][i]})) expect_same(*out);
  while (const auto out = filter.rest()) expect_same(*out);
  EXPECT_EQ(at, 5000u);
  EXPECT_EQ(count, 436u);  // the spikes of each channel
}

TEST(OutlierFilter, WhatIsNoNumberPassesAndIsForgotten) {
  Six columns = noise(2000);
  columns[0][500] = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t i : {std::size_t{700}, std::size_t{900}}) columns[0][i] = i == 700 ? 1000 : std::numeric_limits<double>::infinity();
  const auto replaced = reject_outliers(spans(columns));
  EXPECT_TRUE(std::isnan(columns[0][500]));
  for (std::size_t i = 0; i < replaced.size(); ++i) EXPECT_EQ(replaced[i], i == 700 || i == 900 ? 1 : 0) << i;
}

}  // namespace
}  // namespace imulab
