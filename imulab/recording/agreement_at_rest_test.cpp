#include "imulab/recording/agreement_at_rest.hpp"

#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"
#include <cmath>
#include <limits>
#include <vector>

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

/// A warm-up without noise, of a unit whose accelerometers' biases and scales follow the temperature.
SimulatedSession quiet_warm_up() {
  SimulatedSession s;
  s.session = warm_up_procedure({.minutes = 4}, 1);
  s.truth = draw_truth(s.session, 1);
  s.truth.accel_noise = s.truth.gyro_noise = {};
  TriadModel& accel = s.truth.model.accel;
  accel.thermal.col(1) = Vector3d(2, -3, 4) * 1e-3;
  accel.matrix_thermal1(0, 0) = 2e-4;
  accel.temperature = ThermalReading{.reference = 5, .range = {-20, 30}};
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, 1);
  s.session.steps.clear();
  s.rests = rests_of(s.recording, s.session).ranges;
  return s;
}

std::vector<RestOverTemperature> over_temperature(const SimulatedSession& s, const std::vector<Range>& rests, const SensorModel& model,
                                                  double gravity) {
  return rests_over_temperature(s.recording, gravity_at_rests(s.recording, rests, model, model), model,
                                {gravity, earth_rate_enu(*s.session.site.latitude).z()});
}

TEST(AgreementAtRest, ARestShowsTheErrorOfTheAxisNearTheVertical) {
  const SimulatedSession s = quiet_warm_up();
  const double added = 1e-3;  // m/s^2
  SensorModel biased = s.truth.model;
  biased.accel.offset.array() += added;
  const auto exact = over_temperature(s, s.rests, s.truth.model, s.truth.gravity), off = over_temperature(s, s.rests, biased, s.truth.gravity);
  ASSERT_EQ(exact.size(), s.rests.size());
  const auto all = gravity_at_rests(s.recording, s.rests, s.truth.model, s.truth.model);
  int shown = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    const RestOverTemperature& rest = exact[k];
    EXPECT_NEAR(rest.accel.size, s.truth.gravity, 1e-6);
    const Vector3d up = all[k].force.normalized();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(std::isfinite(rest.accel.error[axis]), std::abs(up[axis]) > std::sqrt(0.5));
      if (!std::isfinite(rest.accel.error[axis])) continue;
      ++shown;
      EXPECT_NEAR(rest.accel.error[axis], 0, 1e-6);
      EXPECT_NEAR(rest.gyro.error[axis], 0, 1e-8);
      EXPECT_NEAR(off[k].accel.error[axis], added * up.sum() / up[axis], 5e-3 * added) << "S is 1 within 5e-3";
    }
  }
  EXPECT_GT(shown, 10);
  EXPECT_LT(exact.front().accel.temperature.x(), -10);
  EXPECT_GT(std::abs(exact.front().accel.size_at_reference - s.truth.gravity), 1e-2) << "20 K from the reference";
}

TEST(AgreementAtRest, PartsOfARestShowTheChangesOfAllAxes) {
  const SimulatedSession s = quiet_warm_up();
  const Range whole = s.rests[1];  // the first one is before it warms
  const std::size_t half = (whole.begin + whole.end) / 2;
  SensorModel off = s.truth.model;
  off.accel.thermal(1, 1) += 1e-3;
  const auto parts = over_temperature(s, {{whole.begin, half}, {half, whole.end}}, off, std::numeric_limits<double>::quiet_NaN());
  ASSERT_EQ(parts.size(), 2u);
  const double warmer = parts[1].accel.temperature.y() - parts[0].accel.temperature.y();
  EXPECT_GT(warmer, 0.1);
  EXPECT_NEAR(parts[1].accel.error.y() - parts[0].accel.error.y(), -1e-3 * off.accel.matrix(1, 1) * warmer, 2e-6);
  EXPECT_TRUE((parts[0].accel.error + parts[1].accel.error).isZero(1e-12));
}

}  // namespace
}  // namespace imulab
