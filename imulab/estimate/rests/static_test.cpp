#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/simulated_session.hpp"

namespace imulab {
namespace {

using testing::Contains;
using testing::HasSubstr;

HandHeldOptions mems(int poses) {
  HandHeldOptions options;
  options.poses = poses;
  options.first_rest = 5;
  return options;
}

void expect_within(const Calibration& c, const SensorModel& truth, double sigmas) {
  for (const CoefficientIndex index : c.estimated)
    EXPECT_LT(std::abs(coefficient_value(c.model, index) - coefficient_value(truth, index)), sigmas * *standard_uncertainty(c, index))
        << coefficient(index).name;
}

/// Returns a procedure with rests on six faces.
SimulatedSession six_faces(std::uint64_t seed) {
  SimulatedSession s;
  s.session = hand_held_procedure(mems(12), seed);
  const double q = 90 * unit::deg;
  const std::array<std::array<double, 3>, 6> faces{{{0, 0, 0}, {0, 2 * q, 0}, {0, q, 0}, {0, -q, 0}, {0, 0, q}, {0, 0, -q}}};
  for (std::size_t k = 0; k < s.session.steps.size(); ++k) s.session.steps[k].angles = faces[k % 6];
  s.truth = draw_truth(s.session, seed);
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, seed);
  Session without_steps = s.session;
  without_steps.steps.clear();
  s.rests = rests_of(s.recording, without_steps).ranges;
  return s;
}

TEST(Static, AccelerometersFromRestsAlone) {
  const SimulatedSession s = simulate_session(mems(20), 1);
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
  EXPECT_EQ(c.estimated.size(), 15u);
  expect_within(c, s.truth.model, 4.3);  // 15 coefficients: p = 1/4000
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("the gyros were not calibrated: they do not resolve Earth's rate")));
  EXPECT_EQ(c.model.gyro.matrix, Matrix3d::Identity());
  EXPECT_EQ(c.model.gyro.offset, Vector3d::Zero());
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(Static, SixFacesGiveScalesAndOffsetsAndNameTheRest) {
  const SimulatedSession s = six_faces(2);
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
  EXPECT_THAT(c.quality.unobservable, testing::ElementsAre("accel.matrix.yx", "accel.matrix.zx", "accel.matrix.zy"));
  EXPECT_EQ(c.estimated.size(), 12u);
  EXPECT_EQ(c.model.accel.matrix(1, 0), 0);
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("doubtful, because 3 coefficients are not determined"));
  // The faces are those of the true body axes, and the misalignment of 1 % (one sigma) is unknown: its effect on scale and offset is of second order,
  // below g (3 x 1e-2)^2 = 9 mm/s^2.
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(c.model.accel.matrix(j, j), s.truth.model.accel.matrix(j, j), 1e-3);
    EXPECT_NEAR(c.model.accel.offset[j], s.truth.model.accel.offset[j], 1e-2);
  }
  CalibrationOptions asked;
  asked.terms = select_coefficients("accel.offset");
  for (const CoefficientIndex index : select_coefficients("accel.matrix.diagonal")) asked.terms.push_back(index);
  EXPECT_TRUE(calibrated("static", s.recording, s.rests, {}, s.site(), asked).quality.unobservable.empty());
}

TEST(Static, OneWeakCoefficientIsNamedAloneAndTheOthersStay) {
  // Gravity is never on y and z at once: the misalignment zy is not observable.
  SimulatedSession s;
  s.session = hand_held_procedure(mems(14), 3);
  for (std::size_t k = 0; k < s.session.steps.size(); ++k)
    s.session.steps[k].angles = {0, (static_cast<double>(k) * 50 - 170) * unit::deg, static_cast<double>(k % 4) * 90 * unit::deg};
  s.truth = draw_truth(s.session, 3);
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, 3);
  const Calibration c = calibrated("static", s.recording, rests_of(s.recording, s.session).ranges, {}, s.site());
  EXPECT_THAT(c.quality.unobservable, testing::ElementsAre("accel.matrix.zy"));
  expect_within(c, s.truth.model, 4.3);
  for (const CoefficientIndex index : select_coefficients("accel.offset"))
    EXPECT_LT(*standard_uncertainty(c, index), 2e-3 * unit::g) << "0.15 mg from the noise; nonlinearity of 0.3 mg/g^2 counts";
}

TEST(Static, RestsOnOneAxisDetermineNothing) {
  SimulatedSession s = six_faces(3);
  std::vector<Range> up_and_down;
  for (std::size_t k = 0; k < s.rests.size(); ++k)
    if (k % 6 < 2) up_and_down.push_back(s.rests[k]);
  ASSERT_EQ(up_and_down.size(), 4u);
  const Calibration c = calibrated("static", s.recording, up_and_down, {}, s.site());
  EXPECT_THAT(c.quality.unobservable, Contains("accel.matrix.xx"));
  EXPECT_THAT(c.quality.unobservable, Contains("accel.offset.y"));
  // The scale of the upright axis is weakly observable: offsets of the others of up to 20 % of g would change it by 1 %.
  const CoefficientIndex upright = coefficient_index("accel.matrix.zz");
  if (contains(c.estimated, upright)) EXPECT_GT(*standard_uncertainty(c, upright), 8e-3);
  Recording counts = s.recording;
  counts.accel_unit = "count";
  EXPECT_THROW(calibrated("static", counts, up_and_down, {}, s.site()), Unsupported);
}

TEST(Static, GyrosFromEarthRate) {
  HandHeldOptions options = mems(24);
  options.first_rest = options.rest = 30;
  options.grade = "navigation";
  const SimulatedSession s = simulate_session(options, 4);
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
  EXPECT_EQ(c.estimated.size(), 36u);
  expect_within(c, s.truth.model, 4.5);
  Site nowhere = s.site();
  nowhere.given_gravity = s.truth.gravity;
  nowhere.latitude.reset();
  const Calibration without = calibrated("static", s.recording, s.rests, {}, nowhere);
  EXPECT_EQ(without.estimated.size(), 15u);
  EXPECT_THAT(without.quality.findings.warnings(), Contains(HasSubstr("the site gives no latitude")));
}

TEST(Static, ABadRestIsDroppedAndNamed) {
  HandHeldOptions options = mems(40);
  options.grade = "tactical";  // the effects of a MEMS unit would explain it
  SimulatedSession s = simulate_session(options, 5);
  for (std::size_t i = s.rests[6].begin; i < s.rests[6].end; ++i)
    for (std::size_t j = 0; j < 3; ++j) s.recording.accel[j][i] *= 1.005;  // along gravity: a rest alone cannot detect a change across it
  const Calibration c = calibrated("static", s.recording, s.rests, s.session.imu, s.site());
  expect_within(c, s.truth.model, 4.3);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("dropped as an outlier: the rest at")));
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(Static, WhatIsStatedHoldsHoweverPoorTheRests) {
  // For few rests, slightly tilted rests, and rests about one axis, coefficients may be undetermined, but stated ones must be correct, and the others
  // must keep the declared unit.
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    for (const int kind : {0, 1, 2}) {
      SimulatedSession s;
      s.session = hand_held_procedure(mems(kind == 0 ? 4 + static_cast<int>(seed) : 12), seed);
      for (Step& step : s.session.steps)
        for (double& angle : step.angles) angle *= kind == 1 ? 10.0 / 180 : 1;  // all within 10 deg of level
      if (kind == 2)
        for (Step& step : s.session.steps) step.angles = {0, step.angles[1], 0};
      s.truth = draw_truth(s.session, seed);
      s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, seed);
      const Calibration c = calibrated("static", s.recording, rests_of(s.recording, s.session).ranges, {}, s.site());
      expect_within(c, s.truth.model, 5);  // some 150 coefficients in all: one beyond 5 sigma has p = 1e-4
      for (const std::string& name : c.quality.unobservable) {
        const CoefficientIndex index = coefficient_index(name);
        EXPECT_EQ(coefficient_value(c.model, index), coefficient_value(SensorModel{}, index)) << name;
      }
      if (kind > 0) {
        EXPECT_FALSE(c.quality.unobservable.empty());
      }
      EXPECT_THAT(c.quality.findings.warnings(), testing::Not(Contains(HasSubstr("dropped"))));
    }
  }
}

TEST(Static, SixFacesOfCountsCountTheMisalignmentInTheOffsets) {
  // Far from the center of the readings, an unknown misalignment moves the offset at raw zero by its fraction of 32768 counts.
  SimulatedSession s = six_faces(4);
  s.recording.accel_unit = "count";
  for (auto& column : s.recording.accel)
    for (double& v : column) v = 32768 + 400 * v;
  SensorModel truth = s.truth.model;
  truth.accel.matrix /= 400;
  truth.accel.offset -= truth.accel.matrix * Vector3d::Constant(32768);
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
  EXPECT_FALSE(c.quality.unobservable.empty());
  expect_within(c, truth, 4.3);
}

TEST(Static, TheOtherHemisphereIsNoticed) {
  HandHeldOptions options = mems(24);
  options.first_rest = options.rest = 30;
  options.grade = "navigation";
  const SimulatedSession s = simulate_session(options, 6);
  Site south = s.site();
  south.latitude = -*south.latitude;
  Recording counts = s.recording;
  counts.gyro_unit = "count";
  for (auto& column : counts.gyro)
    for (double& v : column) v *= 1e9;
  for (const Recording& recording : {s.recording, counts}) {
    const Calibration c = calibrated("static", recording, s.rests, {}, south);
    EXPECT_EQ(c.quality.verdict, Verdict::doubtful);
    EXPECT_EQ(c.quality.cause, "site.latitude");
    EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("nothing contradicts the data; check its sign")));
    EXPECT_EQ(c.estimated.size(), 36u) << "calibrated where the gyros are";
    EXPECT_GT(c.model.gyro.matrix.diagonal().minCoeff(), 0);
  }
}

/// Returns a calibration with navigation-grade gyros whose readings change halfway through the recording.
template <class Change>
Calibration changed_midway(Change change) {
  HandHeldOptions options = mems(24);
  options.first_rest = options.rest = 30;
  options.grade = "navigation";
  SimulatedSession s = simulate_session(options, 9);
  for (auto& column : s.recording.gyro)
    for (std::size_t i = column.size() / 2; i < column.size(); ++i) column[i] = change(column[i]);
  return calibrated("static", s.recording, s.rests, {}, s.site());
}

TEST(Static, GyrosThatChangeMidwayAreDoubted) {
  const auto is_said = [](const Calibration& c) {
    EXPECT_THAT(verdict_text(c.quality), HasSubstr("the gyros' output changes between the rests"));
    EXPECT_THAT(c.quality.findings.warnings(), testing::Not(Contains(HasSubstr("do not resolve"))));
  };
  is_said(changed_midway([](double rate) { return rate - 5 * unit::deg_per_h; }));  // zeroed again
  is_said(changed_midway([](double rate) { return -rate; }));
  is_said(changed_midway([](double rate) { return 2 * rate; }));
  EXPECT_EQ(changed_midway([](double rate) { return rate; }).quality.verdict, Verdict::good);
}

TEST(Static, GyrosThatDoNotResolveTheEarthAndChangeMidwayAreDoubted) {
  SimulatedSession s = simulate_session(mems(20), 1);
  for (auto& column : s.recording.gyro)
    for (std::size_t i = column.size() / 2; i < column.size(); ++i) column[i] -= 1 * unit::deg;
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("the gyros' output changes between the rests"));
}

TEST(Static, TermsThatAreNotAskedForKeepTheDeclaredUnit) {
  const SimulatedSession s = simulate_session(mems(20), 7);
  CalibrationOptions options;
  options.terms = select_coefficients("accel.offset");
  const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site(), options);
  EXPECT_EQ(c.model.accel.matrix, Matrix3d::Identity());
  options.terms = select_coefficients("accel.matrix.xy");
  EXPECT_THROW(calibrated("static", s.recording, s.rests, {}, s.site(), options), Error) << "zero by the frame";
  Recording counts = s.recording;
  counts.accel_unit = "count";
  options.terms = select_coefficients("accel.offset");
  EXPECT_THROW(calibrated("static", counts, s.rests, {}, s.site(), options), Error) << "counts have no scale to start from";
}

/// The rests fit equally well with a reversed axis; the gyros between them do not.
TEST(Static, AReversedAxisIsDoubtedByTheMotion) {
  for (const bool swapped : {false, true}) {
    SimulatedSession s = simulate_session(mems(20), 3);
    if (swapped)
      std::swap(s.recording.accel[0], s.recording.accel[1]);
    else
      for (double& reading : s.recording.accel[2]) reading = -reading;
    const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
    EXPECT_EQ(c.quality.verdict, Verdict::doubtful);
    EXPECT_THAT(c.quality.findings.reasons(), Contains(HasSubstr("as gravity turns in the IMU"))) << swapped;
  }
}

/// The increments were divided by 101.9 Hz although the stamps imply 100 Hz: every scale is too small by 1.9 %.
TEST(Static, IncrementsOfAWrongRateAreDoubted) {
  SimulatedSession s = simulate_session(mems(20), 4);
  s.recording.accel_increment = true;
  const CalibrationInput input{s.session, {&s.recording, 1}, s.rests};
  EXPECT_EQ(calibrate("static", input).calibration.quality.verdict, Verdict::good);
  for (std::vector<double>& axis : s.recording.accel)
    for (double& reading : axis) reading *= 1.019;
  s.recording.interval_s /= 1.019;
  EXPECT_THAT(calibrate("static", input).calibration.quality.findings.reasons(), Contains(HasSubstr("the scales, are 1.9 % off")));
}

TEST(Static, AGravityThatIsNotOfThePlaceIsDoubted) {
  const SimulatedSession s = simulate_session(mems(20), 8);
  Site wrong = s.site();
  wrong.given_gravity = 9.0;
  EXPECT_THAT(verdict_text(calibrated("static", s.recording, s.rests, {}, wrong).quality),
              HasSubstr("the given gravity of 9 m/s^2 is not that of the given latitude"));
}

TEST(Static, CombinationsThatBendAreTrueOrDoubted) {
  // Rests on faces alone do not determine misalignments whose products navigation-grade gyros resolve.
  TableProcedureOptions table;
  table.rate_hz = 20, table.rest = 15;
  int doubted = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SimulatedSession s;
    s.session = cheng_path_procedure(table);
    s.truth = draw_truth(s.session, seed);
    s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, seed);
    s.rests = rests_of(s.recording, s.session).ranges;
    const Calibration c = calibrated("static", s.recording, s.rests, {}, s.site());
    if (c.quality.verdict == Verdict::good) {
      const Eigen::VectorXd error = coefficient_values(c.model, c.estimated) - coefficient_values(s.truth.model, c.estimated);
      EXPECT_GT(chi_square_tail(squared_norm_in(c.covariance, error), static_cast<int>(c.estimated.size())), 1e-4) << seed;
    } else {
      EXPECT_EQ(verdict_text(c.quality), "doubtful, because combinations of coefficients are less certain than stated") << seed;
      ++doubted;
    }
  }
  EXPECT_GT(doubted, 0);
}

}  // namespace
}  // namespace imulab
