// From a recording to the means and sums of its steps, and to a calibration.
#include "imulab/error.hpp"
#include "imulab/rig/table_plan.hpp"
#include "imulab/simulate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/table_session.hpp"

namespace imulab::turntable {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

Session table_session(const std::vector<Step>& steps, double sigma) {
  Session session;
  session.imu = table_imu();
  session.imu.grade = "navigation";
  session.site = table_site();
  session.rigs.push_back(table_of(sigma));
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = 100;
  source.gyro.unit = "rad/s";
  source.accel.unit = "m/s^2";
  session.recordings.push_back(source);
  session.steps = steps;
  return session;
}

std::vector<Step> short_steps() {
  TableSteps steps;
  for (const RigAxis axis : {RigAxis::middle, RigAxis::outer, RigAxis::inner}) {
    std::array<double, 3> turned{};
    turned[static_cast<std::size_t>(axis)] = 360;
    steps.hold(10, {}).turn(axis, 360, 40).hold(10, turned).turn(axis, -360, 40).hold(10, {});
  }
  for (const auto& [inner, middle] : std::vector<std::array<double, 2>>{{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}})
    steps.hold(20, {0, middle, inner});
  return steps.steps();
}

TEST(TurntableObservations, ARecordingGivesTheMeansAndSumsOfItsSteps) {
  const Session session = table_session(short_steps(), 2 * unit::arcsec);
  Truth truth = draw_truth(session, 15);
  truth.accel_noise.N = truth.gyro_noise.N = 0;
  const RigErrors table = draw_rig_errors(session, session.recordings.front(), 15);
  const Recording recording = simulate_recording(session, session.recordings.front(), truth, 15, table);
  const TableObservations seen = observe(recording, session);
  ASSERT_EQ(seen.parts.holds.size(), 15u);
  ASSERT_EQ(seen.parts.turns.size(), 6u);
  EXPECT_THAT(seen.warnings, IsEmpty());
  EXPECT_NEAR(seen.parts.turns[0].begin, 9, 1e-9);     // a second of the rest around a turn is in its sum
  EXPECT_NEAR(seen.parts.holds[0].end, 9.95, 0.0101);  // five sigmas of timing are left out
  const TableMotion motion(seen.parts, session.rigs.front(), session.site);
  VectorXd errors = motion.nominal();
  for (std::size_t k = 0; k < motion.sources().size(); ++k) {
    if (k < table.values.size()) {
      EXPECT_EQ(motion.sources()[k].name, table.sources[k].name());
      errors[static_cast<Index>(k)] = table.values[k];
    }
    if (motion.sources()[k].kind == ErrorSource::Kind::gravity) errors[static_cast<Index>(k)] = truth.gravity;
  }
  // The simulator's quadrature has 1e-10 of 3 g and 500 deg/s; a sum has 2000 samples of 10 ms.
  EXPECT_LT((readings(motion, truth.model, motion.truth(errors)) - seen.readings).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(TurntableObservations, ARecordingIsCalibrated) {
  const Session session = table_session(short_steps(), 2 * unit::arcsec);
  const Truth truth = draw_truth(session, 16);
  const Recording recording = simulate_recording(session, session.recordings.front(), truth, 16);
  const Calibration c = calibrate(input_of(session, recording)).calibration;
  EXPECT_EQ(c.estimated.size(), 45u);  // 24, 9 of g-sensitivity and 12 of nonlinearity
  for (const CoefficientIndex index : c.estimated)
    EXPECT_LT(std::abs(coefficient_value(c.model, index) - coefficient_value(truth.model, index)), 4.5 * *standard_uncertainty(c, index))
        << coefficient(index).name;
  EXPECT_EQ(c.method, "turntable");
}

TEST(TurntableObservations, ATurnThatIsInterruptedOrHasNoRestAroundItIsLeftOut) {
  TableSteps steps;
  steps.hold(10, {}).turn(RigAxis::outer, 90).turn(RigAxis::middle, 90).hold(10, {90, 90, 0}).turn(RigAxis::inner, 90).hold(10, {90, 90, 90});
  const Session session = table_session(steps.steps(), 2 * unit::arcsec);
  const Truth truth = draw_truth(session, 17);
  Recording recording = simulate_recording(session, session.recordings.front(), truth, 17);
  const TableObservations seen = observe(recording, session);
  EXPECT_EQ(seen.parts.turns.size(), 1u);
  EXPECT_THAT(seen.warnings, ElementsAre(HasSubstr("step 2 (rotate at 10 s): no rest of 0.1 s after it"),
                                         HasSubstr("step 3 (rotate at 19.2 s): no rest of 0.1 s before it")));
  recording.gaps = {4500};  // in the last turn
  EXPECT_THAT(observe(recording, session).warnings, Contains(HasSubstr("step 5 (rotate at 38.4 s): the recording is interrupted")));
  Session exact = session;
  exact.rigs.front().timing.value = 0;  // then nothing is lost without rests
  EXPECT_EQ(table_plan(exact, recording.name).turns.size(), 3u);
}

TEST(TurntableObservations, AHoldAtALimitIsLeftOut) {
  const Session session = table_session(short_steps(), 2 * unit::arcsec);
  Recording recording = simulate_recording(session, session.recordings.front(), draw_truth(session, 19), 19);
  for (std::size_t i = 100; i < 900; i += 7) recording.saturated.push_back(i);  // in the first hold, which ends at 10 s
  const TableObservations seen = observe(recording, session);
  EXPECT_EQ(seen.parts.holds.size(), 14u);
  EXPECT_THAT(seen.warnings, Contains(HasSubstr("step 1 (hold at 0 s): 115 of 990 samples are saturated, left out")));
}

TEST(TurntableObservations, WhatIsMissingOrWrongIsSaid) {
  Session session = table_session(short_steps(), 2 * unit::arcsec);
  const Truth truth = draw_truth(session, 18);
  const Recording recording = simulate_recording(session, session.recordings.front(), truth, 18);
  Recording in_g = recording;
  for (auto& column : in_g.accel)
    for (double& x : column) x /= unit::g;
  EXPECT_THROW(calibrate(input_of(session, in_g)), Error);
  Session other = session;
  other.rigs.clear();
  EXPECT_THROW(calibrate(input_of(other, recording)), Error);
  other = session;
  other.steps.clear();
  EXPECT_THROW(calibrate(input_of(other, recording)), Error);
  other = session;
  std::swap(other.steps[1].start, other.steps[1].end);
  EXPECT_THROW(calibrate(input_of(other, recording)), Error);
  other = session;
  for (Step& step : other.steps) step.start += 1e6, step.end += 1e6;
  EXPECT_THROW(calibrate(input_of(other, recording)), Unsupported);
}

}  // namespace
}  // namespace imulab::turntable
