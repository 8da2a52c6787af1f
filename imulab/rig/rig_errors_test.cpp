#include "imulab/core/statistics.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/table_steps.hpp"
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

using unit::arcsec, unit::deg;

/// hold, middle turns by 90 deg, hold, then a hold with other outer and inner angles, and five turns of the inner axis.
Session table() {
  Session s;
  s.rigs.emplace_back();
  s.rigs[0].kind = RigKind::turntable;
  s.rigs[0].angle.value = 60 * arcsec;
  s.rigs[0].orthogonality.value = 50 * arcsec;
  s.rigs[0].zero.value = 40 * arcsec;
  s.rigs[0].timing.value = 10e-3;
  s.steps = {hold_between(0, 1, 0), rotation_between(1, 10.2, RigAxis::middle, 90, 10), hold_between(10.2, 12, 0, 90),
             hold_between(20, 25, 45, 90, -30), rotation_between(25, 205.2, RigAxis::inner, 1800, 10)};
  return s;
}

std::vector<std::string> names(const std::vector<RigErrorSource>& sources) {
  std::vector<std::string> out;
  for (const auto& s : sources) out.push_back(s.name());
  return out;
}

RigErrors exactly(const std::vector<Step>& steps, std::vector<std::pair<std::string, double>> values) {
  Session s = table();
  s.steps = steps;
  RigErrors errors{rig_error_sources(s, {}), {}};
  for (const auto& source : errors.sources) {
    double value = 0;
    for (const auto& [name, x] : values)
      if (name == source.name()) value = x;
    errors.values.push_back(value);
  }
  return errors;
}

TEST(RigErrors, EverySourceIsListedOnceByName) {
  EXPECT_THAT(names(rig_error_sources(table(), {})),
              testing::ElementsAre("orthogonality.outer.1", "orthogonality.outer.2", "orthogonality.middle.1", "orthogonality.middle.2",
                                   "orthogonality.inner.1", "orthogonality.inner.2", "zero.outer", "zero.middle", "zero.inner", "tilt.east",
                                   "tilt.north", "angle.outer.start", "angle.middle.start", "angle.inner.start", "angle.middle.2", "timing.2",
                                   "angle.outer.4", "angle.inner.4", "angle.inner.5", "timing.5"));
}

TEST(RigErrors, AnAxisThatStandsAtZeroIsNoAxis) {
  Session s = table();
  s.steps = {hold_between(0, 1, 0), rotation_between(1, 10.2, RigAxis::outer, 90, 10), hold_between(10.2, 12, 90)};  // a one-axis rate table
  EXPECT_THAT(names(rig_error_sources(s, {})),
              testing::ElementsAre("orthogonality.outer.1", "orthogonality.outer.2", "zero.outer", "zero.middle", "zero.inner", "tilt.east",
                                   "tilt.north", "angle.outer.start", "angle.outer.2", "timing.2"));
  s.rigs[0].kind = RigKind::none;
  EXPECT_TRUE(rig_error_sources(s, {}).empty());  // a hand has no declared errors
}

TEST(RigErrors, WhatIsExactlyGivenIsNotDrawn) {
  Session s = table();
  s.rigs[0].given_orthogonality[2] = {1 * arcsec, 2 * arcsec};
  s.rigs[0].given_zero[0] = 7 * arcsec;
  s.rigs[0].timing = {5e-3, true};
  const auto sources = rig_error_sources(s, {});
  for (const std::uint64_t seed : {1u, 2u}) {
    const RigErrors e = draw_rig_errors(s, {}, seed);
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const std::string name = sources[i].name();
      if (name == "orthogonality.inner.1")
        EXPECT_EQ(e.values[i], 1 * arcsec);
      else if (name == "orthogonality.inner.2")
        EXPECT_EQ(e.values[i], 2 * arcsec);
      else if (name == "zero.outer")
        EXPECT_EQ(e.values[i], 7 * arcsec);
      else if (name.starts_with("tilt"))
        EXPECT_EQ(e.values[i], 0);  // zero_arcsec is the whole zero error
      else if (name.starts_with("timing"))
        EXPECT_EQ(e.values[i], 5e-3);
      else
        EXPECT_NE(e.values[i], 0) << name;
    }
  }
}

TEST(RigErrors, DrawsHaveTheDeclaredSigmaAndTheTableIsSharedByItsRecordings) {
  Session s = table();
  s.rigs[0].name = "table";
  s.recordings.resize(2);
  s.recordings[0].file = "a.csv", s.recordings[1].file = "b.csv";
  s.recordings[0].rig = s.recordings[1].rig = "table";
  for (Step& step : s.steps) step.recording = "a.csv";
  for (const Step& step : std::vector(s.steps)) s.steps.push_back(step), s.steps.back().recording = "b.csv";
  double square = 0, n = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const RigErrors a = draw_rig_errors(s, s.recordings[0], seed), b = draw_rig_errors(s, s.recordings[1], seed);
    ASSERT_EQ(a.sources, b.sources);
    for (std::size_t i = 0; i < a.sources.size(); ++i) {
      const bool of_a_step = a.sources[i].kind == RigErrorKind::angle || a.sources[i].kind == RigErrorKind::timing;
      EXPECT_EQ(a.values[i] == b.values[i], !of_a_step) << a.sources[i].name();
      square += std::pow(a.values[i] / a.sources[i].sigma, 2), ++n;
    }
  }
  EXPECT_GT(square, chi_square_quantile(5e-7, n));  // false alarm once in a million; the seeds are the first hundred
  EXPECT_LT(square, chi_square_quantile(1 - 5e-7, n));
}

TEST(RigErrors, AnAxisTakesUpAnErrorOnlyWhenItMoves) {
  const double e = 1e-4;
  const std::vector<Step> steps{hold_between(0, 1, 0), rotation_between(1, 11, RigAxis::middle, 90, 10), hold_between(21, 22, 10, 90, 0)};
  const RigErrors errors = exactly(
      steps, {{"angle.outer.start", e}, {"angle.middle.start", 2 * e}, {"angle.middle.2", -e}, {"angle.outer.3", 5 * e}, {"zero.inner", 3 * e}});
  const RigMotion m = rig_motion(steps, errors);
  const auto expect = [&](double t, double outer, double middle, double inner) {
    for (const MotionPiece& p : m.pieces)
      if (p.begin <= t && t < p.end) {
        const AxisStates s = axis_states(p, t);
        const double rounding = 1e-15 * 4;  // of angles below 2 rad
        EXPECT_NEAR(s[0].angle, outer, rounding);
        EXPECT_NEAR(s[1].angle, middle, rounding);
        EXPECT_NEAR(s[2].angle, inner, rounding);
      }
  };
  expect(0.5, e, 2 * e, 3 * e);
  expect(11, e, 90 * deg - e, 3 * e);
  expect(21.5, 10 * deg + 5 * e, 90 * deg - e, 3 * e);
}

TEST(RigErrors, ARotationEndsAtItsAngleButLater) {
  const double late = 10e-3;
  const std::vector<Step> steps{hold_between(0, 1, 0), rotation_between(1, 10.2, RigAxis::middle, 90, 10),
                                rotation_between(10.2, 19.4, RigAxis::middle, 90, 10), hold_between(19.4, 30, 0, 180)};
  for (const double delay : {late, -late}) {
    const RigMotion m = rig_motion(steps, exactly(steps, {{"timing.2", delay}}));
    const auto middle = [&](double t) {
      for (const MotionPiece& p : m.pieces)
        if (t < p.end) return axis_states(p, t)[1];
      return AxisState{};
    };
    const double tiny = 1e-12;                                       // s and rad; rounding of times of some ten seconds
    EXPECT_NEAR(middle(10.2 + delay - 1e-9).angle, 90 * deg, 1e-9);  // it still moves, or has moved, at 10 deg/s at most
    EXPECT_NEAR(middle(6).rate, 90 * deg / (9 * (1 + delay / 9.2)), tiny);
    const double begins = std::max(10.2, 10.2 + delay);  // the next step waits for a late one, and for its own time
    EXPECT_NEAR(middle(begins + 1).angle, 99 * deg, tiny);
    EXPECT_NEAR(middle(begins + 9.2).angle, 180 * deg, tiny);
    EXPECT_EQ(m.end(), 30);
  }
}

}  // namespace
}  // namespace imulab
