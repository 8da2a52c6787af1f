#include "imulab/estimate/turntable/tolerance.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/table_steps.hpp"
#include <cmath>

namespace imulab::turntable {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A turn about each axis, and six faces up.
std::vector<Step> short_steps() {
  TableSteps steps;
  steps.hold(20, {}).turn(RigAxis::outer, 360).hold(20, {360, 0, 0}).turn(RigAxis::middle, 360).hold(20, {360, 360, 0}).turn(RigAxis::inner, 360);
  steps.hold(20, {360, 360, 360}).hold(20, {0, 0, 90}).hold(20, {0, 0, 180}).hold(20, {0, 0, 270}).hold(20, {0, 90, 0}).hold(20, {0, -90, 0});
  return steps.steps();
}

Plan short_plan(const std::vector<Step>& steps) {
  Plan plan;
  plan.rig = table_of(20 * unit::arcsec);
  plan.parts = table_plan(steps, plan.rig);
  plan.site = table_site();
  plan.site.given_gravity_sigma = 3e-4;
  plan.accel_noise.N = 5 * unit::ug_per_sqrt_hz;
  plan.gyro_noise.N = 0.001 * unit::deg_per_sqrt_h;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(selector)) plan.terms.push_back(index);
  return plan;
}

TEST(Tolerance, OfWhatIsNotEstimatedIsRefused) {
  Plan plan = short_plan(short_steps());
  const auto required = parse_requirements("gyro.g_sensitivity <= 1 deg/h/g");
  EXPECT_THROW(expect_estimated(required, plan), Error);
  for (const CoefficientIndex index : select_coefficients("gyro.g_sensitivity")) plan.terms.push_back(index);
  EXPECT_NO_THROW(expect_estimated(required, plan));
}

/// The tolerance is the limit: its sizes meet the requirements, sizes 1 % larger do not (it is found within 0.5 %).
TEST(Tolerance, AToleranceMeetsThemAndAPercentMoreDoesNot) {
  const Plan plan = short_plan(short_steps());
  const auto required =
      parse_requirements("gyro.matrix.off_diagonal <= 50 arcsec, accel.offset <= 200 ug, gyro.offset <= 0.1 deg/h, gyro.matrix.diagonal <= 500 ppm");
  for (const Knob knob : {Knob::table, Knob::timing, Knob::imu, Knob::all}) {
    const Tolerance t = tolerance(plan, knob, required);
    ASSERT_TRUE(t.factor) << to_string(knob);
    EXPECT_THAT(shortfalls(scaled(plan, knob, *t.factor), required), IsEmpty()) << to_string(knob);
    EXPECT_EQ(t.unlimited, *t.factor > 0.999 * largest_factor(plan, knob)) << to_string(knob);
    EXPECT_EQ(shortfalls(scaled(plan, knob, 1.01 * *t.factor), required).empty(), t.unlimited) << to_string(knob);
    // The sizes are those of the plan scaled by the factor.
    const double table = knob == Knob::table || knob == Knob::all ? *t.factor : 1, noise = knob == Knob::imu || knob == Knob::all ? *t.factor : 1;
    EXPECT_DOUBLE_EQ(t.sizes.angle, table * 20 * unit::arcsec);
    EXPECT_DOUBLE_EQ(t.sizes.gyro_noise, noise * plan.gyro_noise.N);
  }
}

TEST(Tolerance, TolerancesFallWithWhatIsRequiredAndWithTheOtherErrors) {
  const Plan plan = short_plan(short_steps());
  const auto loose = parse_requirements("gyro.matrix.off_diagonal <= 80 arcsec"),
             strict = parse_requirements("gyro.matrix.off_diagonal <= 40 arcsec");
  const double coarse = tolerance(plan, Knob::table, loose).factor.value(), fine = tolerance(plan, Knob::table, strict).factor.value();
  EXPECT_NEAR(coarse / fine, 2, 0.1);                                                 // the table dominates
  EXPECT_GT(tolerance_alone(plan, Knob::table, strict).factor.value(), 0.99 * fine);  // each found within 0.5 %
  const double noise = tolerance(plan, Knob::imu, strict).factor.value();
  EXPECT_LT(tolerance(scaled(plan, Knob::imu, 0.9 * noise), Knob::table, strict).factor.value(), 0.9 * fine);  // uses up most of the variance
}

/// A requirement is met if its limit equals the larger of predicted u and U/2.
TEST(Tolerance, IsOfWhatTheWorstCoefficientReaches) {
  const Plan plan = short_plan(short_steps());
  const Prediction p = predict(plan);
  double sigma = 0;
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const Coefficient& c = coefficient(p.coefficients[i]);
    if (c.triad == Triad::accel && c.term == Term::offset) sigma = std::max(sigma, p.sigma[static_cast<Eigen::Index>(i)]);
  }
  auto required = parse_requirements("accel.offset <= 1 ug");
  required[0].limit = 0.999 * sigma;
  ASSERT_THAT(shortfalls(plan, required), SizeIs(1));
  const double worst = shortfalls(plan, required)[0].sigma;
  EXPECT_GE(worst, sigma);
  EXPECT_LT(worst, 1.1 * sigma);  // k/2 for 20 degrees of freedom
  required[0].limit = 1.000001 * worst;
  EXPECT_THAT(shortfalls(plan, required), IsEmpty());
  required[0].limit = 0.999999 * worst;
  EXPECT_THAT(shortfalls(plan, required), SizeIs(1));
}

TEST(Tolerance, ThatGravityForbidsIsNotMetByAnyTable) {
  const Plan plan = short_plan(short_steps());
  const auto required = parse_requirements("accel.matrix.diagonal <= 1 ppm");
  for (const Knob knob : {Knob::table, Knob::timing, Knob::imu, Knob::all}) {
    const Tolerance t = tolerance(plan, knob, required);
    EXPECT_FALSE(t.factor) << to_string(knob);
    ASSERT_THAT(t.shortfalls, SizeIs(1)) << to_string(knob);
    EXPECT_EQ(t.shortfalls[0].source, "gravity");
    EXPECT_GE(t.shortfalls[0].sigma, 3e-4 / 9.79);  // contribution of g alone
  }
  EXPECT_TRUE(tolerance_alone(plan, Knob::imu, required).factor);  // with g known, the unit decides
}

TEST(Tolerance, OfACoefficientThatTheProcedureLeavesOpenIsNotMet) {
  const Plan plan = short_plan(TableSteps().hold(60, {0, 0, 0}).hold(60, {0, 0, 90}).hold(60, {0, 0, 180}).hold(60, {0, 0, 270}).steps());
  const auto required = parse_requirements("accel.matrix.xx <= 1 %, accel.offset.y <= 1 g");  // x is never up
  const auto missed = shortfalls(plan, required);
  ASSERT_THAT(missed, SizeIs(1));
  EXPECT_EQ(missed[0].coefficient, coefficient_index("accel.matrix.xx"));
  EXPECT_TRUE(std::isinf(missed[0].sigma));
  EXPECT_FALSE(tolerance(plan, Knob::table, required).factor);
  EXPECT_FALSE(tolerance_alone(plan, Knob::imu, required).factor);
}

/// Exactly known errors are no uncertainty and are not scaled; if no error remains, 1 arcsec and 1 ms are scaled.
TEST(Tolerance, WhatIsKnownOrNotDeclaredIsNotScaled) {
  Plan plan = short_plan(short_steps());
  plan.rig.orthogonality.fixed = true;
  plan.rig.given_zero = {0.0, 0.0, 0.0};
  const ErrorSizes half = error_sizes(scaled(plan, Knob::table, 0.5));
  EXPECT_EQ(half.angle, 10 * unit::arcsec);
  EXPECT_EQ(half.orthogonality, 0);
  EXPECT_EQ(half.zero, 0);
  EXPECT_EQ(scaled(plan, Knob::table, 0.5).rig.orthogonality, plan.rig.orthogonality);

  const auto required = parse_requirements("gyro.matrix.off_diagonal <= 15 arcsec");
  Plan exact = short_plan(short_steps());
  exact.rig = table_of(0, 0);
  const Tolerance t = tolerance(exact, Knob::table, required);
  ASSERT_TRUE(t.factor);
  EXPECT_DOUBLE_EQ(t.sizes.angle, *t.factor * unit::arcsec);
  Plan declared = short_plan(short_steps());
  declared.rig = table_of(unit::arcsec, 0);
  EXPECT_EQ(t.factor, tolerance(declared, Knob::table, required).factor);
}

/// The delay of turns is limited by the guard time of the holds: 5 sigmas in a quarter of the shortest hold, which lasts 20 s.
TEST(Tolerance, TurnsAreNotTriedLaterThanTheHoldsAllow) {
  const Plan plan = short_plan(short_steps());
  EXPECT_DOUBLE_EQ(largest_factor(plan, Knob::timing) * plan.rig.timing.value, 1.0);
  EXPECT_DOUBLE_EQ(largest_factor(plan, Knob::table) * 20 * unit::arcsec, 600 * unit::arcsec);
  EXPECT_EQ(largest_factor(scaled(plan, Knob::timing, 1e4), Knob::timing), 1);
}

/// "All else perfect" includes the Earth's rate, even if the site has no latitude.
TEST(Tolerance, APerfectSiteHasALatitude) {
  Plan plan = short_plan(short_steps());
  plan.rig.timing.value = 0;
  const auto required = parse_requirements("gyro.offset <= 0.02 deg/h");
  const double known = tolerance_alone(plan, Knob::imu, required).factor.value();
  plan.site.latitude.reset();
  EXPECT_NEAR(tolerance_alone(plan, Knob::imu, required).factor.value() / known, 1, 0.05);  // relative to another latitude, 45 deg
}

}  // namespace
}  // namespace imulab::turntable
