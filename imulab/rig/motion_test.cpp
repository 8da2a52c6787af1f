#include "imulab/rig/motion.hpp"

#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

using unit::deg;
constexpr double rounding = 1e-12;  // rad, rad/s: a few hundred roundings of angles of some radians

Step hold(double start, double end, double outer, double middle = 0, double inner = 0) {
  Step s;
  s.start = start, s.end = end, s.angles = {outer * deg, middle * deg, inner * deg};
  return s;
}

Step rotation(double start, double end, RigAxis axis, double angle, double rate, std::optional<double> acceleration = {}) {
  Step s;
  s.kind = StepKind::rotate, s.start = start, s.end = end, s.axis = axis, s.angle = angle * deg, s.rate = rate * deg;
  if (acceleration) s.acceleration = *acceleration * deg;
  return s;
}

AxisStates axes_at(const RigMotion& m, double t) {
  for (const MotionPiece& p : m.pieces)
    if (t < p.end) return axis_states(p, t);
  return axis_states(m.pieces.back(), t);
}

/// Integral of an axis's rate by the midpoint rule: independent of the angle's own polynomial.
double turned(const RigMotion& m, std::size_t axis, double begin, double end) {
  const int n = 20000;
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += axes_at(m, begin + (k + 0.5) * (end - begin) / n)[axis].rate;
  return sum * (end - begin) / n;
}

TEST(Motion, IntegratedRateOfARotationIsItsAngle) {
  const std::vector<Step> cases{
      rotation(1, 10, RigAxis::middle, 90, 10),         // no ramps: 9 s
      rotation(1, 10.2, RigAxis::middle, -90, 10),      // ramps of 0.2 s
      rotation(1, 12, RigAxis::middle, 90, 10, 50),     // ramps of 0.2 s, then waits
      rotation(1, 12, RigAxis::middle, 3, 100, 50),     // never reaches its rate
      rotation(1, 181.5, RigAxis::middle, 1800, 10.0),  // five turns
  };
  for (const Step& step : cases) {
    const RigMotion m = rig_motion(std::vector{hold(0, 1, 20, 30, 40), step});
    EXPECT_DOUBLE_EQ(m.end(), step.end);
    // The midpoint rule misplaces the ends of the ramps by at most a step of 1e-4 of the time, at the highest rate: four of them.
    EXPECT_NEAR(turned(m, 1, step.start, step.end), step.angle, 4 * step.rate * (step.end - step.start) / 20000);
    EXPECT_NEAR(axes_at(m, step.end)[1].angle, 30 * deg + step.angle, rounding * (1 + std::abs(step.angle)));
    for (const std::size_t other : {0u, 2u})
      EXPECT_DOUBLE_EQ(axes_at(m, 0.5 * (step.start + step.end))[other].angle, other == 0 ? 20 * deg : 40 * deg);
  }
}

TEST(Motion, TrapezoidHasTheRampsItsTimesImply) {
  const RigMotion m = rig_motion(std::vector{rotation(0, 9.2, RigAxis::outer, 90, 10)});  // 90 = 10 (9.2 - ramp)
  EXPECT_NEAR(axes_at(m, 0.1)[0].rate, 5 * deg, rounding);
  EXPECT_NEAR(axes_at(m, 0.1)[0].acceleration, 50 * deg, 1e-9);  // a difference of times near 9 s, over 0.2 s
  EXPECT_NEAR(axes_at(m, 4)[0].rate, 10 * deg, rounding);
  EXPECT_NEAR(axes_at(m, 9.1)[0].rate, 5 * deg, rounding);
  const RigMotion given = rig_motion(std::vector{rotation(0, 12, RigAxis::outer, 90, 10, 50)});
  for (const double t : {0.05, 0.3, 5.0, 9.1}) EXPECT_NEAR(axes_at(given, t)[0].angle, axes_at(m, t)[0].angle, rounding);
  EXPECT_EQ(axes_at(given, 10)[0].rate, 0);  // it waits
}

TEST(Motion, MovesInAGapBeginAndEndAtRestWithoutAJerk) {
  const RigMotion m = rig_motion(std::vector{hold(0, 1, 0, 10, 0), hold(3, 4, 90, -20, 0)});
  for (const double t : {1.0, 3.0 - 1e-12}) {
    for (const AxisState& a : axes_at(m, t)) {
      EXPECT_NEAR(a.rate, 0, rounding);
      EXPECT_NEAR(a.acceleration, 0, 1e-9);  // 60 u a / T^2 at u = 1e-12
    }
  }
  EXPECT_NEAR(axes_at(m, 2)[0].angle, 45 * deg, rounding);
  EXPECT_NEAR(axes_at(m, 2)[0].rate, 1.875 * 90 * deg / 2, rounding);  // 15/8 of the mean rate
  EXPECT_NEAR(axes_at(m, 2)[1].angle, -5 * deg, rounding);
  EXPECT_NEAR(axes_at(m, 3.5)[1].angle, -20 * deg, rounding);
  EXPECT_TRUE(m.pieces.front().at_rest());
  EXPECT_FALSE(m.pieces[1].at_rest());
}

TEST(Motion, AnglesAndRatesAreContinuousWithRamps) {
  const RigMotion m = rig_motion(std::vector{hold(0, 1, 0), rotation(1, 4, RigAxis::inner, -50, 20), hold(6, 7, 30, 40, 50)});
  for (std::size_t k = 1; k < m.pieces.size(); ++k) {
    EXPECT_EQ(m.pieces[k].begin, m.pieces[k - 1].end);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(axis_states(m.pieces[k], m.pieces[k].begin)[a].angle, axis_states(m.pieces[k - 1], m.pieces[k].begin)[a].angle, rounding);
      EXPECT_NEAR(axis_states(m.pieces[k], m.pieces[k].begin)[a].rate, axis_states(m.pieces[k - 1], m.pieces[k].begin)[a].rate, rounding);
    }
  }
}

TEST(Motion, WholeTurnsAreNotRepeatedInAGap) {
  const std::vector<Step> steps{rotation(0, 180, RigAxis::outer, 1800, 10), hold(180, 181, 0), hold(191, 192, 1890)};
  const RigMotion m = rig_motion(steps);
  EXPECT_NEAR(turned(m, 0, 180, 181), 0, rounding);
  EXPECT_NEAR(turned(m, 0, 181, 191), 90 * deg, 1e-7);  // midpoint rule on a quintic: (1/20000)^2 of the whole
}

TEST(Motion, BeginsAtZeroOrAtAHoldThatBeginsAtOnce) {
  const RigMotion gap = rig_motion(std::vector{hold(10, 20, 90)}), none = rig_motion(std::vector{hold(0, 20, 90)});
  EXPECT_EQ(axes_at(gap, 0)[0].angle, 0);
  EXPECT_NEAR(axes_at(gap, 15)[0].angle, 90 * deg, rounding);
  EXPECT_EQ(axes_at(none, 0)[0].angle, 90 * deg);
}

TEST(Motion, WhatCannotBeDoneIsNamed) {
  const auto message = [](const std::vector<Step>& steps) -> std::string {
    try {
      rig_motion(steps);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  using testing::AllOf, testing::HasSubstr;
  Step spin = hold(1, 2, 0);
  spin.kind = StepKind::spin;
  EXPECT_THAT(message({}), HasSubstr("no steps"));
  EXPECT_THAT(message({hold(0, 1, 0), spin}), AllOf(HasSubstr("step 2 (spin"), HasSubstr("expected hold or rotate")));
  EXPECT_THAT(message({hold(0, 2, 0), hold(1, 3, 0)}), AllOf(HasSubstr("step 2"), HasSubstr("from 2 s on")));
  EXPECT_THAT(message({hold(0, 0, 0)}), HasSubstr("a later end"));
  EXPECT_THAT(message({hold(0, 1, 0), hold(1, 2, 5)}), HasSubstr("without time to reach them"));
  EXPECT_THAT(message({rotation(0, 8, RigAxis::outer, 90, 10)}), HasSubstr("take 9 to 18 s"));
  EXPECT_THAT(message({rotation(0, 19, RigAxis::outer, 90, 10)}), HasSubstr("give the acceleration"));
  EXPECT_THAT(message({rotation(0, 9, RigAxis::outer, 90, 10, 50)}), HasSubstr("take 9.2 s"));
  EXPECT_THAT(message({rotation(0, 9, RigAxis::outer, 90, 0)}), HasSubstr("expected a rate above 0"));
  EXPECT_THAT(message({rotation(0, 9, RigAxis::outer, 90, 10, 0)}), HasSubstr("the acceleration is not positive"));
}

TEST(Motion, StepsBelongToTheirRecordingAndRig) {
  Session session;
  session.recordings.resize(2);
  session.recordings[0].file = "a.csv", session.recordings[1].file = "b.csv";
  session.steps = {hold(0, 1, 0), hold(0, 2, 0)};
  session.steps[0].recording = "a.csv", session.steps[1].recording = "b.csv";
  ASSERT_EQ(session.steps_of(session.recordings[1]).size(), 1u);
  EXPECT_EQ(session.steps_of(session.recordings[1])[0].end, 2);
  EXPECT_EQ(session.rig_of(session.recordings[1]), nullptr);
  session.rigs.resize(2);
  session.rigs[0].name = "arm", session.rigs[1].name = "table";
  session.recordings[1].rig = "table";
  EXPECT_EQ(session.rig_of(session.recordings[1]), &session.rigs[1]);
}

}  // namespace
}  // namespace imulab
