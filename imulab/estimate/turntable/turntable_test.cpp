#include "imulab/estimate/turntable/turntable.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/simulate.hpp"

#include <Eigen/LU>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/table_session.hpp"
#include <cmath>
#include <numbers>

namespace imulab::turntable {
namespace {

using Eigen::VectorXd;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Turntable, KnownTableErrorsAreTakenOut) {
  RigDeclaration rig = table_of(0);
  const std::array<std::array<double, 2>, 3> known{{{1e-3, -2e-3}, {3e-3, 1e-3}, {-1e-3, 2e-3}}};
  for (std::size_t a = 0; a < 3; ++a) rig.given_orthogonality[a] = known[a];
  rig.given_zero = {1e-3, 2e-3, -1e-3};
  const TableRun run = run_of(zhang_steps(), rig, 6, 0);
  const Calibration c = calibrate(run.seen, rig, table_imu(), table_site());
  for (const CoefficientIndex index : c.estimated) {
    // Without noise and with known errors, the result is the truth, except for rounding of sums of 31 rad with weights over eight orders.
    EXPECT_NEAR(coefficient_value(c.model, index), coefficient_value(run.truth, index), 1e-10) << coefficient(index).name;
  }
  EXPECT_EQ(c.frame, BodyFrame::rig);
}

// Table errors of an arcminute are nonlinear compared with a thousandth of a navigation-grade unit's noise.
TEST(Turntable, NoiseFarBelowTheTablesErrorsConverges) {
  constexpr double less = 1e-3;
  const RigDeclaration rig = table_of(60 * unit::arcsec);
  const TableMotion motion(table_plan(zhang_steps(), 5 * rig.timing.value), rig, table_site());
  const VectorXd errors = motion.nominal() + motion.sigma().cwiseProduct(drawn_normals(motion.sigma().size(), 3, "table"));
  ImuDeclaration imu = table_imu();
  imu.accel_noise_density = less * table_accel_noise, imu.gyro_noise_density = less * table_gyro_noise;
  const TableRun run = run_of(zhang_steps(), rig, 3, less, errors);
  const Calibration c = calibrate(run.seen, rig, imu, table_site());
  EXPECT_TRUE(c.quality.converged);
  EXPECT_EQ(c.quality.verdict, Verdict::good) << testing::PrintToString(c.quality.findings.reasons());
}

TEST(Turntable, RoundedReadingsAreNoDifferent) {
  TableRun run = run_of(zhang_steps(), table_of(2 * unit::arcsec), 7, 1);
  const Calibration c = calibrate(run.seen, table_of(2 * unit::arcsec), table_imu(), table_site());
  for (Eigen::Index i = 0; i < run.seen.readings.size(); ++i) run.seen.readings[i] *= 1 + (i % 3 == 0 ? 0x1p-52 : -0x1p-53);
  const Calibration rounded = calibrate(run.seen, table_of(2 * unit::arcsec), table_imu(), table_site());
  for (const CoefficientIndex index : c.estimated) {
    const double sigma = standard_uncertainty(c, index).value(), value = coefficient_value(c.model, index);
    const double rounding = 8 * 0x1p-52 * std::abs(value);  // the sigma of a scale factor near one is 1e-7
    EXPECT_NEAR(coefficient_value(rounded.model, index), value, 1e-10 * sigma + rounding) << coefficient(index).name;
  }
}

TEST(Turntable, CountsWithALargeOffsetAreNoDifferent) {
  TableRun run = run_of(zhang_steps(), table_of(2 * unit::arcsec), 7, 1);
  ImuDeclaration imu = table_imu();
  imu.grade = "navigation";  // the same priors for any offset
  const Calibration si = calibrate(run.seen, table_of(2 * unit::arcsec), imu, table_site());
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < run.seen.parts.holds.size(); ++k, row += 6) {
    auto accel = run.seen.readings.segment<3>(row), gyro = run.seen.readings.segment<3>(row + 3);
    accel = 1e5 * accel + Vector3d::Constant(32768);
    gyro = 1e7 * gyro + Vector3d::Constant(-1000);
  }
  for (const TablePart& turn : run.seen.parts.turns) {
    auto sum = run.seen.readings.segment<3>(row);
    sum = 1e7 * sum + Vector3d::Constant(-1000 * (turn.end - turn.begin));
    row += 3;
  }
  run.seen.accel_unit = run.seen.gyro_unit = "count";
  const Calibration counts = calibrate(run.seen, table_of(2 * unit::arcsec), imu, table_site());
  // Subtract the offset from the readings; the second-order terms about it are those of the SI readings.
  const SensorModel centered = of_shifted_readings(counts.model, Vector3d::Constant(-32768), Vector3d::Constant(1000));
  // 1e5 counts are 1 m/s^2, and rounding of 1e6 counts is 1e-10 counts; the remaining difference is the start of the first pass.
  EXPECT_LT((1e5 * centered.accel.matrix - si.model.accel.matrix).norm(), 1e-7);
  EXPECT_LT((1e7 * centered.gyro.matrix - si.model.gyro.matrix).norm(), 1e-7);
  EXPECT_EQ(counts.quality.unobservable, si.quality.unobservable);
  EXPECT_EQ(counts.quality.verdict, Verdict::good);
  EXPECT_EQ(counts.model.gyro.raw_unit, "count");
}

/// Returns an IMU whose gyros do not resolve the Earth's rate in minutes.
ImuDeclaration blind_imu() {
  ImuDeclaration imu;
  imu.accel_noise_density = 100 * unit::ug_per_sqrt_hz;
  imu.gyro_noise_density = 20 * unit::deg_per_sqrt_h;
  return imu;
}

TEST(Turntable, WithoutTurnsTheGyroMatrixIsNamed) {
  std::vector<Step> steps = zhang_steps();
  std::erase_if(steps, [](const Step& step) { return step.kind == StepKind::rotate; });
  const TableRun run = run_of(steps, table_of(2 * unit::arcsec), 8, 1);
  const Calibration c = calibrate(run.seen, table_of(2 * unit::arcsec), blind_imu(), table_site());
  std::vector<std::string> matrix;
  for (const CoefficientIndex index : select_coefficients("gyro.matrix")) matrix.emplace_back(coefficient(index).name);
  EXPECT_EQ(c.quality.unobservable, matrix);
  EXPECT_LT((c.model.gyro.matrix - Matrix3d::Identity()).norm(), 1e-15);  // its start, inverted twice
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("doubtful, because 9 coefficients are not determined"));
  // Navigation-grade gyros do determine it from the Earth's rate, a thousand times less accurately than from turns.
  const Calibration good = calibrate(run.seen, table_of(2 * unit::arcsec), table_imu(), table_site());
  EXPECT_THAT(good.quality.unobservable, IsEmpty());
  EXPECT_GT(*standard_uncertainty(good, coefficient_index("gyro.matrix.xx")), 1e-5);
}

TEST(Turntable, TurnsAboutOneAxisDetermineItsColumn) {
  TableSteps steps;
  for (const auto& [inner, middle] : std::vector<std::array<double, 2>>{{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}})
    steps.hold(30, {0, middle, inner});
  steps.hold(30, {}).turn(RigAxis::outer, 720).hold(30, {720, 0, 0}).turn(RigAxis::outer, -720).hold(30, {});
  TableRun run = run_of(steps.steps(), table_of(2 * unit::arcsec), 9, 1);
  const Calibration c = calibrate(run.seen, table_of(2 * unit::arcsec), blind_imu(), table_site());
  EXPECT_THAT(c.quality.unobservable,
              ElementsAre("gyro.matrix.xx", "gyro.matrix.xy", "gyro.matrix.yx", "gyro.matrix.yy", "gyro.matrix.zx", "gyro.matrix.zy"));
  EXPECT_NEAR(c.model.gyro.matrix(0, 0), 1, 1e-15);  // its start, inverted twice
}

TEST(Turntable, AWrongStepIsNamed) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  TableRun run = run_of(zhang_steps(), rig, 10, 1);
  const Calibration good = calibrate(run.seen, rig, table_imu(), table_site());
  EXPECT_THAT(good.quality.findings.warnings(), IsEmpty());
  EXPECT_EQ(good.quality.verdict, Verdict::good);
  const auto name_of = [&](const TablePart& part) { return step_name(run.seen.parts.steps[part.step], part.step); };
  TableRun bad = run;
  bad.seen.readings[6 * 20 + 1] += 1e-3;  // ten times the effect of a table error of 2 arcsec
  const Calibration c = calibrate(bad.seen, rig, table_imu(), table_site());
  const std::string name = name_of(run.seen.parts.holds[20]);
  EXPECT_THAT(c.quality.findings.warnings(), ElementsAre("dropped as an outlier: " + name));
  for (const CoefficientIndex index : c.estimated)
    EXPECT_LT(std::abs(coefficient_value(c.model, index) - coefficient_value(good.model, index)), *standard_uncertainty(c, index));
  // The turn is half of the declared one.
  bad = run;
  bad.seen.readings.segment<3>(static_cast<Eigen::Index>(6 * run.seen.parts.holds.size() + 3 * 3)) *= 0.5;
  EXPECT_THAT(calibrate(bad.seen, rig, table_imu(), table_site()).quality.findings.warnings(),
              ElementsAre("dropped as an outlier: " + name_of(run.seen.parts.turns[3])));
}

TEST(Turntable, AWorseTableThanDeclaredIsSaid) {
  const RigDeclaration actual = table_of(60 * unit::arcsec), declared = table_of(2 * unit::arcsec);
  const TableMotion motion(table_plan(zhang_steps(), 0.05), actual, table_site());
  const VectorXd errors = motion.nominal() + motion.sigma().cwiseProduct(drawn_normals(motion.sigma().size(), 11, "table"));
  const TableRun run = run_of(zhang_steps(), declared, 11, 1, errors);
  const Calibration c = calibrate(run.seen, declared, table_imu(), table_site());
  EXPECT_THAT(c.quality.findings.warnings(),
              Contains(HasSubstr("times what the noise and the declared table errors explain; the uncertainties are enlarged")));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("the residuals exceed the declared noise and table errors"));
}

TEST(Turntable, AReversedAxisIsNamed) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  for (const std::size_t axis : {0u, 1u, 2u}) {
    TableRun run = run_of(zhang_steps(), rig, 12, 1);
    for (Step& step : run.seen.parts.steps) {
      step.angles[axis] *= -1;
      if (step.kind == StepKind::rotate && static_cast<std::size_t>(step.axis) == axis) step.angle *= -1;
    }
    const Calibration c = calibrate(run.seen, rig, table_imu(), table_site());
    EXPECT_THAT(c.quality.findings.warnings(),
                Contains(HasSubstr(std::string(to_string(static_cast<RigAxis>(axis))) + " axis seems to turn against")))
        << axis;
    EXPECT_THAT(verdict_text(c.quality), HasSubstr("sign of an axis"));
  }
}

TEST(Turntable, AReversedSensorIsNoReversedAxisOfTheTable) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  for (const Eigen::Index axis : {0, 1, 2}) {
    TableRun run = run_of(zhang_steps(), rig, 12, 1);
    for (Eigen::Index k = 0; k < std::ssize(run.seen.parts.holds); ++k) run.seen.readings[6 * k + axis] *= -1;
    const Calibration c = calibrate(run.seen, rig, table_imu(), table_site());
    EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr(fmt::format("accelerometer {} (or the gyros", "xyz"[axis]))));
    EXPECT_THAT(c.quality.findings.warnings(), testing::Not(Contains(HasSubstr("axis seems to turn against"))));
    EXPECT_THAT(verdict_text(c.quality), HasSubstr("sign of an axis"));
  }
}

TEST(Turntable, GSensitivityIsEstimatedWhereItIs) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  TableRun run = run_of(zhang_steps(), rig, 13, 1);
  EXPECT_FALSE(calibrate(run.seen, rig, table_imu(), table_site()).quality.term_tests.front().kept);
  SensorModel with = run.truth;
  with.g_sensitivity << 1e-8, 2e-8, 0, 0, 1e-8, 0, -2e-8, 0, 3e-8;  // up to 0.06 deg/h/g
  run.seen.readings = readings(run.motion, with, run.motion.truth(run.motion.nominal())) + drawn_noise(run.motion, with, 13);
  const Calibration c = calibrate(run.seen, rig, table_imu(), table_site());
  EXPECT_TRUE(c.quality.term_tests.front().kept);
  for (const CoefficientIndex index : c.estimated)
    EXPECT_LT(std::abs(coefficient_value(c.model, index) - coefficient_value(with, index)),
              4.8 * *standard_uncertainty(c, index));  // 33 coefficients: p = 1/20000
}

TEST(Turntable, TermsThatTheDataCannotExcludeCount) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  const TableRun run = run_of(zhang_steps(), rig, 15, 1);
  CalibrationOptions terms_alone;
  terms_alone.effects = false;
  const Calibration plain = calibrate(run.seen, rig, table_imu(), table_site(), terms_alone);
  const std::vector<CoefficientIndex> linear = linear_terms();
  EXPECT_EQ(plain.estimated.size(), linear.size() + 12 + 9);
  EXPECT_THAT(plain.quality.unobservable, IsEmpty());
  // Holds at 1 g up and down do not separate a cubic term from the scale: it stays zero and enters its uncertainty.
  EXPECT_THAT(plain.quality.considered, Contains("accel.cubic.x"));
  EXPECT_EQ(plain.model.accel.cubic, Vector3d::Zero());
  CalibrationOptions alone = terms_alone;
  alone.terms = linear;
  const Calibration without = calibrate(run.seen, rig, table_imu(), table_site(), alone);
  EXPECT_EQ(without.estimated, linear);
  const double cubic = *standard_uncertainty(plain, coefficient_index("accel.cubic.x")) * unit::g * unit::g;
  const CoefficientIndex scale = coefficient_index("accel.matrix.xx");
  EXPECT_NEAR(*standard_uncertainty(plain, scale), std::hypot(*standard_uncertainty(without, scale), cubic), 0.1 * cubic);
  EXPECT_GT(*standard_uncertainty(plain, coefficient_index("accel.offset.x")),
            5 * *standard_uncertainty(without, coefficient_index("accel.offset.x")));
}

TEST(Turntable, AWrongHemisphereIsNamed) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  const TableRun run = run_of(zhang_steps(), rig, 16, 1);
  Site declared = table_site();
  declared.latitude = -*declared.latitude;
  const Calibration c = calibrate(run.seen, rig, table_imu(), declared);
  const std::string right = fmt::format("as a latitude of {:.0f}.", *table_site().latitude / unit::deg);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr(right)));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("the latitude seems to be wrong"));
}

TEST(Turntable, HoldsAndTurnsAreListed) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  TableRun run = run_of(zhang_steps(), rig, 10, 1);
  run.seen.readings[6 * 20 + 1] += 1e-3;
  const Quality quality = calibrate(run.seen, rig, table_imu(), table_site()).quality;
  ASSERT_EQ(quality.rests.size(), run.seen.parts.holds.size());
  ASSERT_EQ(quality.rotations.size(), run.seen.parts.turns.size());
  for (std::size_t k = 0; k < quality.rests.size(); ++k) EXPECT_EQ(quality.rests[k].used, k != 20) << k;
  for (const PartResidual& rest : quality.rests) EXPECT_LE(rest.residual, quality.rests[20].residual);
  EXPECT_EQ(quality.rests[20].begin_s, run.seen.parts.holds[20].begin);
}

TEST(Turntable, TermsByHand) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  const TableRun run = run_of(zhang_steps(), rig, 14, 1);
  CalibrationOptions options;
  options.terms = select_coefficients("accel.matrix.diagonal");
  EXPECT_EQ(calibrate(run.seen, rig, table_imu(), table_site(), options).estimated, options.terms);
  options.terms = {coefficient_index("gyro.matrix.xy")};
  EXPECT_THROW(calibrate(run.seen, rig, table_imu(), table_site(), options), Error);
  TableObservations counts = run.seen;
  counts.gyro_unit = "count";
  options.terms = select_coefficients("accel.matrix.diagonal");
  EXPECT_THROW(calibrate(counts, rig, table_imu(), table_site(), options), Error);
  options.terms = {coefficient_index("gyro.quadratic.x")};
  EXPECT_THROW(calibrate(run.seen, rig, table_imu(), table_site(), options), Error);
}

}  // namespace
}  // namespace imulab::turntable
