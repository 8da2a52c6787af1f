// Effects of the table in whole-unit calibration. tests/effects_simulation tests them on random units.
#include "imulab/earth.hpp"
#include "imulab/estimate/kernel/site.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/estimate/whole_unit/stepwise.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/whole_unit_session.hpp"
#include <algorithm>

namespace imulab::whole_unit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

WholeUnitSession navigation_session(std::uint64_t seed) {
  DaiUnitOptions options;
  options.record = 1;
  options.grade = "navigation";
  return whole_unit_session(seed, options, [](Session&) {});
}

PointProblem problem_of(const WholeUnitSession& s) {
  const MachinePoints points = machine_points(s.recordings, s.session);
  const Vector6d center = reading_center(points);
  return {points, s.session, starting_model(points, s.session, center), center};
}

CalibrationOptions with_effects() {
  CalibrationOptions options = full_whole_unit();
  options.effects = true;
  return options;
}

const EffectEstimate& effect_of(const Calibration& c, const std::string& name) {
  return *std::find_if(c.quality.effects.begin(), c.quality.effects.end(), [&](const EffectEstimate& e) { return e.name == name; });
}

TEST(WholeUnitEffects, ColumnsAreTheDerivativesOfTheResiduals) {
  const WholeUnitSession s = navigation_session(1);
  PointProblem problem = problem_of(s);
  problem.add_effects({});
  ASSERT_GT(problem.effects.size(), 100);
  const auto& points = problem.points.all;
  for (const std::size_t at : {std::size_t{3}, std::size_t{20}, points.size() - 1}) {
    const Vector6d before = problem.equations(points[at]).residual;
    const Eigen::MatrixXd& by_effects = problem.by_effects[points[at].recording][points[at].number];
    for (Index k = 0; k < problem.effects.size(); ++k) {
      const Index column = problem.size() - problem.effects.size() + k;
      const double step = problem.parameters().sigma[column];
      PointProblem moved = problem;
      moved.correct(step * VectorXd::Unit(problem.size(), column));
      const Vector6d change = (moved.equations(points[at]).residual - before) / step, expected = by_effects.col(k);
      const std::string_view name = problem.effects.columns()[static_cast<std::size_t>(k)].effect->name;
      const double of_arm = name == "site.latitude" ? 5e-3 : 0;  // m/s^2: the column neglects the Earth's rate in a centrifuge's rotation
      EXPECT_LT((change - expected).norm(), 1e-3 * expected.norm() + 1e-12 / step + of_arm) << name;
    }
  }
}

/// The effect of the site is the derivative of the machine's motion, at rest or turning.
TEST(WholeUnitEffects, TheSiteMovesTheEarthsRateAndGravity) {
  Session session = dai_unit_procedure({});
  const auto at = [&](const Step& step, double latitude, double heading) {
    Site site = session.site;
    *site.latitude += latitude;
    Step turned = step;
    turned.angles[0] += heading;
    return steady_motion(turned, site);
  };
  const kernel::SiteChanges site(session.site);
  constexpr double h = 1e-4;
  for (const std::size_t k : {std::size_t{0}, std::size_t{15}, std::size_t{35}}) {  // the chamber, a spin, and a hold on the rate table
    const Step& step = session.steps[k];
    EffectState state;
    Matrix3d C_bn = mount_attitude(mount_of(step)).transpose();
    if (step.kind == StepKind::spin) C_bn = (C_bn * Vector3d::UnitZ() * Vector3d::UnitZ().transpose()).eval();
    site.fill(state, C_bn);
    const Motion north = at(step, h, 0), south = at(step, -h, 0), left = at(step, 0, h), right = at(step, 0, -h);
    EXPECT_LT(((north.rate - south.rate) / (2 * h) - state.by_latitude.rate).norm(), 1e-6 * earth_rate);
    EXPECT_LT(((north.force - south.force) / (2 * h) - state.by_latitude.force).norm(), 1e-4 * state.by_latitude.force.norm());
    if (step.kind == StepKind::hold) EXPECT_LT(((left.rate - right.rate) / (2 * h) - state.by_heading.rate).norm(), 1e-6 * earth_rate);
  }
}

TEST(WholeUnitEffects, WithoutThemNothingIsAdded) {
  const WholeUnitSession s = navigation_session(2);
  const Calibration c = calibrate(s.input(), full_whole_unit()).calibration;
  EXPECT_THAT(c.quality.effects, IsEmpty());
  EXPECT_FALSE(c.quality.cause);
}

/// A chamber with one mount does not determine this effect, however accurate its data are.
TEST(WholeUnitEffects, WhatThePointsDoNotShowKeepsHalfOfItsSize) {
  const Calibration c = calibrate(navigation_session(3).input(), with_effects()).calibration;
  const Effect& hidden = *find_effect("accel.scale_temperature");
  for (const double sigma : effect_of(c, std::string(hidden.name)).sigma) EXPECT_GT(sigma, 0.45 * hidden.prior[1]);
}

/// A turn-on change of 200 ug between recordings is detected, declared or not: it is eight times the expected size of the grade.
TEST(WholeUnitEffects, AnotherZeroInOneRecordingIsATurnOn) {
  WholeUnitSession s = navigation_session(3);
  const Vector3d shift = 200 * unit::ug * Vector3d(1, -1, 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (double& x : s.recordings[2].accel[axis]) x += shift[static_cast<Index>(axis)];
  const Calibration named = calibrate(s.input(), with_effects()).calibration;
  EXPECT_TRUE(effect_of(named, "accel.turn_on").significant);
  const double next = named.next_switch_on.at("accel.offset.x") / unit::ug;
  EXPECT_GT(next, 80) << "the shifts of one recording of three have an RMS of 115 ug";
  EXPECT_LT(next, 400);
  EXPECT_NEAR(named.turn_on->accel, 200 * unit::ug / 3, 100 * unit::ug / 3);
  SensorModel mean = s.truth.model;  // mean of the three recordings
  mean.accel.offset -= shift / 3;
  const VectorXd errors = errors_of(named, mean);
  for (Index k = 0; k < errors.size(); ++k) EXPECT_LT(std::abs(errors[k]), 5 * std::sqrt(named.covariance(k, k)));
  s.session.imu.accel_noise = NoiseModel{.turn_on = {200 * unit::ug}};
  const Calibration declared = calibrate(s.input(), with_effects()).calibration;
  EXPECT_EQ(declared.quality.verdict, Verdict::good);
  const EffectEstimate& found = effect_of(declared, "accel.turn_on");
  ASSERT_EQ(found.values.size(), 6u);
  for (std::size_t axis = 0; axis < 3; ++axis)  // Helmert's second contrast: the first two against the third
    EXPECT_NEAR(found.values[3 + axis], -200 * shift.normalized()[static_cast<Index>(axis)] * std::sqrt(3.0) * 2 / std::sqrt(6.0),
                4 * found.sigma[3 + axis]);
}

TEST(WholeUnitEffects, ALatitudeOfTheWrongSignIsNamed) {
  WholeUnitSession s = navigation_session(4);
  s.session.site.latitude = -*s.session.site.latitude;
  const Calibration c = calibrate(s.input(), with_effects()).calibration;
  EXPECT_NE(c.quality.verdict, Verdict::good);
  EXPECT_EQ(c.quality.cause.value_or(""), "site.latitude");
  const VectorXd e = errors_of(c, s.truth.model);  // the gyros imply this latitude
  for (Index k = 0; k < e.size(); ++k) EXPECT_LT(std::abs(e[k]), 5 * std::sqrt(c.covariance(k, k)));
}

}  // namespace
}  // namespace imulab::whole_unit
