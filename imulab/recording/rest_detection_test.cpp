#include "imulab/core/random.hpp"
#include "imulab/recording/lost_rests.hpp"
#include "imulab/rests.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>

namespace imulab {
namespace {

SimulatedSession session_of(std::uint64_t seed) {
  HandHeldOptions options;
  options.poses = 20;
  options.first_rest = 20;
  return simulate_session(options, seed);
}

TEST(RestDetection, FindsEveryRestAndNothingElse) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedSession s = session_of(seed);
    ASSERT_EQ(s.rests.size(), s.session.steps.size());
    for (std::size_t k = 0; k < s.rests.size(); ++k) {
      const double start = s.recording.time_s(s.rests[k].begin), end = s.recording.time_s(s.rests[k].end - 1);
      const Step& step = s.session.steps[k];
      // Inside the hold up to a stride (0.05 s) of motion that has hardly begun, and at most a tenth of a window and a stride lost.
      EXPECT_GE(start, step.start - 0.06);
      EXPECT_LE(start, step.start + 0.16);
      EXPECT_LE(end, step.end + 0.06);
      EXPECT_GE(end, step.end - 0.16);
    }
  }
}

TEST(RestDetection, DoesNotDependOnUnitsOrZeros) {
  const SimulatedSession s = session_of(6);
  Recording counts = s.recording;
  counts.gyro_unit = counts.accel_unit = "count";
  for (std::size_t j = 0; j < 3; ++j) {
    for (double& v : counts.gyro[j]) v = 32768 + 4096 * v;  // powers of two: the same bits, shifted
    for (double& v : counts.accel[j]) v = -1024 * v;
  }
  EXPECT_EQ(detect_rests(counts).rests, s.rests);
}

TEST(RestDetection, RoundedReadingsHaveTheirRestsFromTheFirstOn) {
  // A phone's: 0.1 deg/s and 0.1 m/s^2, above the noise. Within a rest an axis stays at one step, or goes to and fro between two.
  SimulatedSession s = simulate_session(short_hand_held(), 12, [](Truth& t) { t.gyro_noise.N = 2e-5, t.accel_noise.N = 1e-3; });
  const auto round_to = [](Columns3& triad, double step) {
    for (auto& column : triad)
      for (double& v : column) v = step * std::round(v / step);
  };
  round_to(s.recording.gyro, 0.1 * unit::deg), round_to(s.recording.accel, 0.1);
  for (std::size_t rests = 2; rests <= s.rests.size(); ++rests) {
    Recording begun = s.recording;
    const std::size_t end = s.rests[rests - 1].end;
    begun.time_ns.resize(end);
    for (auto* triad : {&begun.gyro, &begun.accel})
      for (auto& column : *triad) column.resize(end);
    EXPECT_EQ(detect_rests(begun).rests.size(), rests);
  }
}

TEST(RestDetection, CountsTheRestsOfAnotherUnitAsLost) {
  SimulatedSession s = session_of(13);
  for (std::size_t i = s.rests[13].begin; i < s.recording.size(); ++i)
    for (auto& column : s.recording.gyro) column[i] += 0.05;
  Session session = s.session;
  session.steps.clear();
  LostRests lost;
  const Rests rests = rests_of(RecordingView(s.recording), session, lost);
  EXPECT_EQ(rests.ranges.size(), 13U);
  EXPECT_GE(lost.shifted, s.rests.size() - 14) << "one may lie along the vertical by chance";
  EXPECT_EQ(lost.moving, 0U);
}

/// Behind the first rest the readings become those that `moved` makes of them: in a hand, on a road.
Recording behind_the_desk(std::uint64_t seed, const std::function<double(const SimulatedSession&, std::size_t column, std::size_t i)>& moved) {
  HandHeldOptions options;
  options.poses = 12;
  options.first_rest = 60;
  SimulatedSession s = simulate_session(options, seed);
  Recording r = s.recording;
  for (std::size_t column = 0; column < 6; ++column)
    for (std::size_t i = s.rests[0].end; i < r.size(); ++i) (column < 3 ? r.gyro : r.accel)[column % 3][i] = moved(s, column, i);
  return r;
}

double reading_of(const SimulatedSession& s, std::size_t column, std::size_t i) {
  return (column < 3 ? s.recording.gyro : s.recording.accel)[column % 3][i];
}

double trembling(const SimulatedSession& s, std::size_t column, std::size_t i) {
  const double t = s.recording.time_s(i), size = 1 + 0.6 * std::sin(0.3 * t);  // 7 Hz: the angle stays within a degree
  return reading_of(s, column, i) + size * (column < 3 ? 0.04 : 0.01) * std::sin(44 * t + static_cast<double>(column));
}

TEST(RestDetection, FindsPausesInATremblingHandBehindADesk) {
  const RestDetection found = detect_rests(behind_the_desk(8, trembling));
  EXPECT_EQ(found.rests.size(), 12u);
  EXPECT_GT(found.gyro_noise[0], 0.01) << "that of the pauses";
}

TEST(RestDetection, WhatRunsBehindADeskHasNoPauses) {
  const auto vehicle = [](const SimulatedSession& s, std::size_t column, std::size_t i) {  // runs level, turns, and shakes in places
    const double t = s.recording.time_s(i), rough = i % 700 < 300 ? 1 : 0.1;
    const double shake = rough * (column < 3 ? 0.05 : 0.5) * std::sin((31 + 5 * static_cast<double>(column)) * t);
    const double motion = column == 2 ? 0.2 * std::sin(0.4 * t) : column == 3 ? 1.5 * std::sin(0.25 * t) : column == 4 ? std::sin(0.4 * t) : 0;
    return reading_of(s, column, s.rests[0].end - 1 - i % 500) + shake + motion;
  };
  const auto aircraft = [](const SimulatedSession& s, std::size_t column, std::size_t i) {  // under other forces than gravity at times
    constexpr std::array<double, 3> load{1.0, 1.5, 0.6};
    std::size_t pose = 0;
    while (pose + 1 < s.rests.size() && s.rests[pose].end <= i) ++pose;
    return trembling(s, column, i) * (column < 3 ? 1 : load[pose % 3]);
  };
  EXPECT_EQ(detect_rests(behind_the_desk(9, vehicle)).rests.size(), 1u);
  EXPECT_EQ(detect_rests(behind_the_desk(8, aircraft)).rests.size(), 1u);
}

TEST(RestDetection, DoesNotLeanOnAnInitialRest) {
  const SimulatedSession s = session_of(7);
  const std::size_t cut = s.rests[0].end + 50;  // begin in motion
  Recording later = s.recording;
  later.time_ns.erase(later.time_ns.begin(), later.time_ns.begin() + static_cast<std::ptrdiff_t>(cut));
  for (auto* columns : {&later.gyro, &later.accel})
    for (auto& column : *columns) column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(cut));
  const auto found = detect_rests(later).rests;
  ASSERT_EQ(found.size(), s.rests.size() - 1);
  for (std::size_t k = 0; k < found.size(); ++k) {
    // The strides begin elsewhere and the thresholds come from other windows: a few strides (5 samples each).
    EXPECT_NEAR(static_cast<double>(found[k].begin + cut), static_cast<double>(s.rests[k + 1].begin), 15);
    EXPECT_NEAR(static_cast<double>(found[k].end + cut), static_cast<double>(s.rests[k + 1].end), 15);
  }
}

TEST(RestDetection, SteadyTurningIsNoRest) {
  SimulatedSession s = session_of(8);
  const Range turning = s.rests[4];
  for (std::size_t axis = 0; axis < 3; ++axis)  // about the vertical: invisible to the accelerometers
    for (std::size_t i = turning.begin; i < turning.end; ++i) s.recording.gyro[axis][i] += 0.05 * s.recording.accel[axis][turning.begin];
  const RestDetection found = detect_rests(s.recording);
  EXPECT_EQ(found.rests.size(), s.rests.size() - 1);
  EXPECT_EQ(found.turning, 1u);
  EXPECT_EQ(found.notes.size(), 2u);
}

/// Without noise: rests of 20 s, turns of 4 s between them. Times `scale`, about `zero`.
Recording ideal(double gyro_scale, double accel_scale, double zero) {
  Recording r;
  r.interval_s = 0.01;
  for (int i = 0; i < 12000; ++i) {
    r.time_ns.push_back(std::int64_t{10'000'000} * (i + 1));
    const double t = 0.01 * (i % 2400), rate = t < 20 ? 0 : 0.5 * std::pow(std::sin(3.14159265358979 * (t - 20) / 4), 2);
    for (std::size_t k = 0; k < 3; ++k) {
      r.gyro[k].push_back(zero + gyro_scale * (4e-5 + rate));
      r.accel[k].push_back(zero + accel_scale * (5 + rate));
    }
  }
  return r;
}

TEST(RestDetection, FindsTheRestsOfAnIdealUnitWhole) {
  Recording si = ideal(1, 1, 0), exact = ideal(1e6, 1e4, 100), rounded = exact, coarse = ideal(100, 100, 0);
  si.gyro_unit = "rad/s";
  si.accel_unit = "m/s^2";
  for (Recording* r : {&rounded, &coarse})
    for (auto* columns : {&r->gyro, &r->accel})
      for (auto& column : *columns)
        for (double& v : column) v = std::round(v);
  for (const Recording& r : {si, exact, rounded, coarse}) {
    const std::vector<Range> rests = detect_rests(r).rests;
    ASSERT_EQ(rests.size(), 5u) << r.gyro_unit;
    for (std::size_t k = 0; k < 5;
         ++k) {  // a stride (5 samples) is trimmed, one may reach into motion that has hardly begun; in coarse counts it shows late
      EXPECT_NEAR(static_cast<double>(rests[k].begin), 2400. * static_cast<double>(k), 20);
      EXPECT_NEAR(static_cast<double>(rests[k].end), 2400. * static_cast<double>(k) + 2000, 20);
    }
  }
}

TEST(RestDetection, NoRestInARecordingShorterThanTwoWindows) {
  Recording r;
  r.interval_s = 0.01;
  for (int i = 0; i < 10; ++i) r.time_ns.push_back(10'000'000 * i);
  for (auto* columns : {&r.gyro, &r.accel})
    for (auto& column : *columns) column.assign(10, 0.0);
  EXPECT_TRUE(detect_rests(r).rests.empty());
}

TEST(RestDetection, GapsAndSaturatedSamplesCutARange) {
  Recording r;
  r.gaps = {5, 20};
  r.saturated = {8, 9, 30};
  EXPECT_EQ(without_interruptions(r, {2, 12}), (std::vector<Range>{{2, 5}, {5, 8}, {10, 12}}));
  EXPECT_EQ(without_interruptions(r, {5, 8}), (std::vector<Range>{{5, 8}})) << "a gap before the first sample is outside";
  r.time_ns.resize(40);
  for (int i = 0; i < 40; ++i) r.time_ns[static_cast<std::size_t>(i)] = 10'000'000 * (i + (i >= 5 ? 2 : 0) + (i >= 20 ? 30 : 0));
  EXPECT_EQ(without_interruptions(r, {2, 8}, still_s), (std::vector<Range>{{2, 8}})) << "30 ms";
  EXPECT_EQ(without_interruptions(r, {10, 25}, still_s), (std::vector<Range>{{10, 20}, {20, 25}})) << "310 ms";
  EXPECT_EQ(without_interruptions(r, {10, 20}), (std::vector<Range>{{10, 20}}));
  EXPECT_EQ(without_interruptions(r, {29, 31}), (std::vector<Range>{{29, 30}}));
}

}  // namespace
}  // namespace imulab
