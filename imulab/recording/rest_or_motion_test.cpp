// Rests are told from motion by what a sensor's noise can be, not by the quietest part of the log.
#include "imulab/recording/rest_or_motion.hpp"

#include "imulab/core/random.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace imulab {
namespace {

using Reading = std::array<double, 6>;  // gyro, accel

/// A minute at 100 Hz of a poor sensor that moves so.
Recording moved(const std::function<Reading(double t)>& motion) {
  constexpr std::size_t n = 6'000;
  const std::array<double, 6> noise{2e-3, 2e-3, 2e-3, 0.03, 0.03, 0.03};
  std::vector<double> t(n);
  Columns3 gyro, accel;
  for (Columns3* triad : {&gyro, &accel})
    for (auto& column : *triad) column.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    t[i] = 0.01 * static_cast<double>(i + 1);
    const Reading at = motion(t[i]);
    for (std::size_t c = 0; c < 6; ++c)
      (c < 3 ? gyro : accel)[c % 3][i] = at[c] + noise[c] * RandomStream(7, static_cast<std::uint64_t>(c)).normal(i);
  }
  return make_recording(t, std::move(gyro), std::move(accel));
}

double wave(double t, double hz, double phase = 0) { return std::sin(2 * std::numbers::pi * hz * t + phase); }

double longest_rest_s(const Recording& recording) {
  double longest = 0;
  for (const Range& rest : detect_rests(recording).rests) longest = std::max(longest, 0.01 * static_cast<double>(rest.size()));
  return longest;
}

TEST(RestOrMotion, KnowsWhatMovesThroughout) {
  const struct {
    const char* what;
    std::function<Reading(double)> motion;
  } rows[] = {
      {"a drone that hovers",
       [](double t) {
         return Reading{0.05 * wave(t, 0.7), 0.04 * wave(t, 0.45, 1), 0.02 * wave(t, 0.2),
                        0.3 * wave(t, 0.45), 0.4 * wave(t, 0.7),      9.8 + 2 * wave(t, 31)};
       }},
      {"a car",
       [](double t) {
         return Reading{0.01 * wave(t, 1.3), 0.01 * wave(t, 1.1), 0.05 * wave(t, 0.05),
                        0.8 * wave(t, 0.03), 0.7 * wave(t, 0.05), 9.8 + 0.5 * wave(t, 12)};
       }},
      {"walking",
       [](double t) {
         return Reading{0.5 * wave(t, 0.9), 0.4 * wave(t, 1.8), 0.3 * wave(t, 0.9, 1), 1.5 * wave(t, 1.8), wave(t, 0.9), 9.8 + 3 * wave(t, 1.8)};
       }},
      {"a slow turn about a level axis",
       [](double t) { return Reading{0, 0.3 * unit::deg, 0, 9.8 * std::sin(0.3 * unit::deg * t), 0, 9.8 * std::cos(0.3 * unit::deg * t)}; }},
      {"a quick steady turn about the vertical", [](double) { return Reading{0, 0, 40 * unit::deg, 0.1, 0, 9.8}; }},
  };
  for (const auto& row : rows) EXPECT_LT(longest_rest_s(moved(row.motion)), 30) << row.what;
}

TEST(RestOrMotion, KnowsWhatRests) {
  const Recording still = moved([](double) { return Reading{0.03, -0.02, 0.01, 0.3, -0.2, 9.7}; });
  EXPECT_GT(longest_rest_s(still), 59);
  EXPECT_TRUE(doubts_about_rest(still, {0, still.size()}).empty());
  const Recording warming = moved([](double t) { return Reading{0.03 + 2e-5 * t, 0, 0, 1e-4 * t, -0.2, 9.7}; });
  EXPECT_GT(longest_rest_s(warming), 59) << "an offset that drifts";
  const Recording engine =
      moved([](double t) { return Reading{0.03 * wave(t, 23), 0.02 * wave(t, 23), 0, wave(t, 23), 0.7 * wave(t, 46), 9.8 + wave(t, 23, 1)}; });
  EXPECT_GT(longest_rest_s(engine), 59) << "vibration is no motion";
  EXPECT_NE(doubts_about_rest(engine, {0, engine.size()}).at(1).find("vibrates"), std::string::npos);
}

TEST(RestOrMotion, JudgesCountsByGravity) {
  Recording counts = moved([](double t) { return Reading{0, 0.05 * wave(t, 0.3), 0, 2 * wave(t, 0.3), 0, 9.8}; });
  counts.gyro_unit = counts.accel_unit = "count";
  for (auto& column : counts.accel)
    for (double& v : column) v *= 1000;
  const Range all{0, counts.size()};
  EXPECT_EQ(motion_in(counts, all), "");
  EXPECT_NE(motion_in(counts, all, true), "");
}

}  // namespace
}  // namespace imulab
