#include "imulab/rig/table_attitude.hpp"

#include "imulab/rig/motion.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/table_session.hpp"

namespace imulab {
namespace {

using Eigen::Index;

const Orthogonality<double> skewed{{{1e-2, -2e-2}, {3e-2, 1e-2}, {-1e-2, 2e-2}}};

TEST(TableAttitude, IsTheTurntables) {
  const TableAxes<double> axes = table_axes(skewed);
  const std::array<double, 3> angles{0.3, -1.2, 2.5};
  const TablePose<double> pose = table_pose(axes, angles);
  const BodyState state =
      turntable_state({axes[0], axes[1], axes[2]}, {AxisState{angles[0], 0.1, 0}, AxisState{angles[1], 0.2, 0}, AxisState{angles[2], 0.3, 0}});
  const Matrix3d C_nt = table_tilt(0.01, -0.02);
  for (const Vector3d& v : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {  // rounding of a product of five rotations
    EXPECT_LT((seen_in_body(pose, v) - state.C_nb.transpose() * v).norm(), 1e-14);
    EXPECT_LT((seen_by_table(table_tilt_of(0.01, -0.02), v) - C_nt.transpose() * v).norm(), 1e-14);
  }
  const Vector3d rate =
      0.1 * axis_in_body(pose, RigAxis::outer) + 0.2 * axis_in_body(pose, RigAxis::middle) + 0.3 * axis_in_body(pose, RigAxis::inner);
  EXPECT_LT((rate - state.rate_nb_b).norm(), 1e-14);
}

/// The integral of the measured rate by Simpson's rule over the rig's motion.
Vector3d integrated_rate(const RigMotion& motion, const Vector3d& rate_ie_n, double begin, double end) {
  Vector3d sum = Vector3d::Zero();
  for (const MotionPiece& piece : motion.pieces) {
    const double from = std::max(begin, piece.begin), to = std::min(end, piece.end);
    if (to <= from) continue;
    const int panels = 4000;
    const double h = (to - from) / (2 * panels);
    for (int k = 0; k <= 2 * panels; ++k) {
      const double weight = k == 0 || k == 2 * panels ? 1 : k % 2 == 1 ? 4 : 2;
      const BodyState state = turntable_state(motion.axes, axis_states(piece, from + h * k));
      sum += weight * h / 3 * (state.rate_nb_b + state.C_nb.transpose() * rate_ie_n);
    }
  }
  return sum;
}

TEST(TableAttitude, ATurnsSumIsTheIntegralOfTheRate) {
  const Vector3d rate_ie_n(0, 0.2, 0.3);              // not Earth's: large, so that an error shows
  for (const double degrees : {1800.0, -247.0, 3.0})  // the last never reaches its rate
    for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner}) {
      TableSteps steps;
      steps.hold(20, {20, 40, -70}).turn(axis, degrees, 30);
      const Step& turn_step = steps.steps()[1];
      const TableAxes<double> axes = table_axes(skewed);
      RigErrors errors{table_error_sources(RigDeclaration{}, steps.steps()), {}};
      for (const RigErrorSource& source : errors.sources)
        errors.values.push_back(source.kind == RigErrorKind::orthogonality ? skewed[source.axis][source.element] : 0);
      const RigMotion motion = rig_motion(steps.steps(), errors);
      const double begin = turn_step.start - 5;
      const TurnProfile profile = turn_profile(turn_step);
      const TablePose<double> pose = table_pose(axes, turn_step.angles);
      const TurnInterval<double> turn{axis_in_body(pose, axis), turn_step.angle, 5, profile.duration, 0, profile.ramp};
      const Vector3d rate = turn.axis_b * turn.angle + integral_in_body<double>(turn, seen_in_body<double>(pose, rate_ie_n));
      // Simpson with steps of at most 0.25 s / 8000 ... 60 s / 8000 on harmonics of 30 deg/s: below (h w)^4 / 180 of 20 rad, 1e-11.
      EXPECT_LT((rate - integrated_rate(motion, rate_ie_n, begin, turn_step.start + profile.duration)).norm(), 1e-9) << degrees << to_string(axis);
    }
}

TEST(TableAttitude, ATurnWithoutAccelerationFillsItsStep) {
  Step step;
  step.angle = 90 * unit::deg;
  step.rate = 10 * unit::deg;
  step.end = 9.5;  // 9 s at constant rate and half a second of ramps
  EXPECT_NEAR(turn_profile(step).ramp * 9.5, 0.5, 1e-12);
  step.end = 9;
  EXPECT_NEAR(turn_profile(step).ramp, 0, 1e-12);
}

/// The exact derivatives against central differences, for every error source of Zhang's procedure.
TEST(TableMotion, JacobianAgreesWithDifferences) {
  const TablePlan plan = table_plan(zhang_steps(), 0.05);
  const TableMotion motion(plan, table_of(1 * unit::arcsec), table_site());
  const Eigen::VectorXd at = motion.nominal() + 1e-3 * drawn_normals(motion.nominal().size(), 1, "errors");
  const Eigen::MatrixXd exact = motion.jacobian(at);
  const double step = 1e-5;
  for (Index k = 0; k < at.size(); ++k) {
    Eigen::VectorXd plus = at, minus = at;
    plus[k] += step;
    minus[k] -= step;
    const Eigen::VectorXd difference = (motion.truth(plus) - motion.truth(minus)) / (2 * step);
    // Third derivatives are of the size of the truth: g 120 s, 1e3, times 1e-10 / 6; rounding 1e3 1e-16 / 1e-5.
    EXPECT_LT((difference - exact.col(k)).cwiseAbs().maxCoeff(), 1e-6) << motion.sources()[static_cast<std::size_t>(k)].name;
  }
}

TEST(TableMotion, AnAngleErrorStaysUntilTheAxisMovesAgain) {
  TableSteps steps;
  steps.hold(10, {}).hold(10, {90, 0, 0}).hold(10, {90, 90, 0}).turn(RigAxis::outer, 360).hold(10, {450, 90, 0});
  const TableMotion motion(table_plan(steps.steps(), 0), table_of(1 * unit::arcsec), table_site());
  std::vector<std::string> names;
  for (const ErrorSource& source : motion.sources())
    if (source.kind == ErrorSource::Kind::angle) names.push_back(source.name);
  EXPECT_EQ(names, (std::vector<std::string>{"angle.outer.start", "angle.middle.start", "angle.outer.2", "angle.middle.3", "angle.outer.4"}));
}

}  // namespace
}  // namespace imulab
