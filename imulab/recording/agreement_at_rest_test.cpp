#include "imulab/recording/agreement_at_rest.hpp"

#include "imulab/units.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"
#include <cmath>

namespace imulab {
namespace {

/// A handheld session without noise: the truth leaves rounding alone.
SimulatedSession quiet_session() {
  return simulate_session({.poses = 8}, 3, [](Truth& truth) { truth.accel_noise = truth.gyro_noise = {}; });
}

TEST(AgreementAtRest, TheTruthFindsGravityAtEveryRest) {
  const SimulatedSession s = quiet_session();
  const SensorModel& truth = s.truth.model;
  const auto rests = gravity_at_rests(s.recording, s.rests, uncalibrated(truth), truth);
  ASSERT_EQ(rests.size(), s.rests.size());
  double worst_before = 0;
  for (const GravityAtRest& rest : rests) {
    EXPECT_NEAR(rest.after, s.truth.gravity, 1e-6);
    worst_before = std::max(worst_before, std::abs(rest.before - s.truth.gravity));
  }
  EXPECT_GT(worst_before, 1e-3);
}

TEST(AgreementAtRest, TheTruthTakesGravityAlong) {
  const SimulatedSession s = quiet_session();
  const SensorModel& truth = s.truth.model;
  const auto rests = gravity_at_rests(s.recording, s.rests, uncalibrated(truth), truth);
  const auto turns = turn_errors(s.recording, rests, uncalibrated(truth), truth);
  ASSERT_EQ(turns.size() + 1, rests.size());
  for (const TurnError& turn : turns) {
    EXPECT_GT(turn.angle, 5 * unit::deg);
    EXPECT_LT(turn.after, 0.01 * unit::deg);  // the rectangle rule in fast turns at 100 Hz
    EXPECT_GT(turn.before, 5 * turn.after);
  }
}

TEST(AgreementAtRest, ATurnWithAGapIsLeftOut) {
  SimulatedSession s = quiet_session();
  const SensorModel& truth = s.truth.model;
  s.recording.gaps = {s.rests[0].end + 2};
  const auto rests = gravity_at_rests(s.recording, s.rests, uncalibrated(truth), truth);
  EXPECT_EQ(turn_errors(s.recording, rests, uncalibrated(truth), truth).size() + 2, rests.size());
}

TEST(AgreementAtRest, CountsHaveOneScaleBefore) {
  SensorModel m;
  m.accel.raw_unit = "count", m.gyro.raw_unit = "rad/s";
  m.accel.offset = {-30, -31, -32};
  m.accel.matrix = Vector3d(0.001, 0.002, 0.003).asDiagonal();
  m.accel.matrix(1, 0) = 0.1;
  m.gyro.offset = {1, 2, 3};
  const SensorModel plain = uncalibrated(m);
  EXPECT_TRUE(plain.accel.matrix.isApprox(0.002 * Matrix3d::Identity()));
  const Vector3d zero = -m.accel.matrix.inverse() * m.accel.offset;
  EXPECT_TRUE((plain.accel.matrix * zero + plain.accel.offset).isZero(1e-9)) << "zero at the same readings";
  EXPECT_TRUE(plain.gyro.offset.isZero(0));
  EXPECT_TRUE(plain.gyro.matrix.isIdentity(0));
}

TEST(AgreementAtRest, AnEmptyRangeIsLeftOut) {
  const SimulatedSession s = quiet_session();
  EXPECT_TRUE(gravity_at_rests(s.recording, {Range{5, 5}}, SensorModel{}, SensorModel{}).empty());
}

}  // namespace
}  // namespace imulab
