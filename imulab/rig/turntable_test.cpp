#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace imulab {
namespace {

double gen(double low, double high) { return low + (high - low) * (*rc::gen::inRange(0, 1000001)) * 1e-6; }

/// Axes a few degrees from orthogonal, so that a law that holds for ideal axes alone fails.
RigAxes skewed_axes() { return {Vector3d(0.03, -0.02, 1).normalized(), Vector3d(0.04, 1, 0.01).normalized(), Vector3d(1, 0.02, -0.05).normalized()}; }

/// Angles as a + b t + c t^2 / 2 + d t^3 / 6.
struct Path {
  std::array<std::array<double, 4>, 3> c;
  AxisStates at(double t) const {
    AxisStates s;
    for (std::size_t i = 0; i < 3; ++i)
      s[i] = {c[i][0] + t * (c[i][1] + t * (c[i][2] / 2 + t * c[i][3] / 6)), c[i][1] + t * (c[i][2] + t * c[i][3] / 2), c[i][2] + t * c[i][3]};
    return s;
  }
};

Path any_path() {
  Path path{};
  for (auto& axis : path.c) axis = {gen(-4, 4), gen(-3, 3), gen(-3, 3), gen(-3, 3)};
  return path;
}

RC_GTEST_PROP(Turntable, AttitudeIsARotation, ()) {
  const Matrix3d c = turntable_state(skewed_axes(), any_path().at(0)).C_nb;
  // A product of three rotation matrices: a few roundings.
  RC_ASSERT((c * c.transpose() - Matrix3d::Identity()).norm() < 1e-14);
  RC_ASSERT(std::abs(c.determinant() - 1) < 1e-14);
}

RC_GTEST_PROP(Turntable, RateIsTheDerivativeOfAttitudeAndAccelerationOfRate, ()) {
  const Path path = any_path();
  const RigAxes axes = skewed_axes();
  const double h = 1e-4;
  const auto at = [&](double t) { return turntable_state(axes, path.at(t)); };
  const BodyState now = at(0), before = at(-h), after = at(h);
  // Central differences: h^2 / 6 of a third derivative, which rates of 9 rad/s in sum (and 9 rad/s^2, 9 rad/s^3) bound by about 1e3 and 1e4;
  // rounding 1e-16 / h is far below.
  RC_ASSERT(((after.C_nb - before.C_nb) / (2 * h) - now.C_nb * skew<double>(now.rate_nb_b)).norm() < 1e3 * h * h);
  RC_ASSERT(((after.rate_nb_b - before.rate_nb_b) / (2 * h) - now.angular_acceleration_nb_b).norm() < 1e4 * h * h);
}

// The independent path to the size effect: the accelerometer's position in inertial space, differentiated twice.
RC_GTEST_PROP(Turntable, SizeEffectIsTheSecondDerivativeOfThePlace, ()) {
  const Path path = any_path();
  const RigAxes axes = skewed_axes();
  Surroundings around{.rate_ie_n = {0.1, 0.4, 0.3}, .gravity = 9.8};  // an Earth that turns fast enough to be visible
  around.lever_arm << 0.1, -0.2, 0.3, -0.1, 0.2, 0.1, 0.3, 0.1, -0.2;
  const double h = 1e-3;
  const auto C_ib = [&](double t) -> Matrix3d { return rotation_exp(around.rate_ie_n * t) * turntable_state(axes, path.at(t)).C_nb; };
  const Motion sensed = sensed_motion(turntable_state(axes, path.at(0)), around);
  for (int i = 0; i < 3; ++i) {
    const Vector3d r = around.lever_arm.row(i);
    const Vector3d acceleration = (C_ib(h) * r - 2 * C_ib(0) * r + C_ib(-h) * r) / (h * h);
    const Vector3d expected = C_ib(0).transpose() * (acceleration + Vector3d(0, 0, around.gravity));
    // h^2 / 12 of the fourth derivative, 0.4 m times about 2e4 1/s^4 at those rates; rounding 1e-16 / h^2 is far below.
    RC_ASSERT(std::abs(expected(i) - sensed.force(i)) < 1e3 * h * h);
  }
}

TEST(Turntable, AxesTurnAsTheContractSays) {
  const auto attitude = [](double outer, double middle, double inner) {
    return turntable_state(ideal_axes(), {AxisState{outer * unit::deg}, AxisState{middle * unit::deg}, AxisState{inner * unit::deg}}).C_nb;
  };
  const Vector3d east = Vector3d::UnitX(), north = Vector3d::UnitY(), up = Vector3d::UnitZ();
  const double tiny = 1e-15;  // one rounding of cos 90 deg
  EXPECT_LT((attitude(0, 0, 0) - Matrix3d::Identity()).norm(), tiny);
  EXPECT_LT((attitude(90, 0, 0) * east - north).norm(), tiny);  // about up
  EXPECT_LT((attitude(0, 90, 0) * up - east).norm(), tiny);     // about north
  EXPECT_LT((attitude(0, 0, 90) * north - up).norm(), tiny);    // about east
  EXPECT_LT((attitude(90, 0, 90) * north - up).norm(), tiny);   // the inner axis is turned by the outer, not the reverse
  EXPECT_LT((attitude(90, 0, 90) * east - north).norm(), tiny);
}

RC_GTEST_PROP(Turntable, AtRestOnlyGravityAndEarthAreSensed, ()) {
  const double latitude = gen(-90, 90) * unit::deg;
  const AxisStates still{AxisState{gen(-4, 4)}, AxisState{gen(-4, 4)}, AxisState{gen(-4, 4)}};
  const BodyState body = turntable_state(ideal_axes(), still);
  const Motion m = sensed_motion(body, {earth_rate_enu(latitude), 9.8});
  const double rounding = 4e-15;  // some 18 roundings: a product of three rotations and a vector
  RC_ASSERT(std::abs(m.force.norm() - 9.8) < 9.8 * rounding);
  RC_ASSERT(std::abs(m.rate.norm() - earth_rate) < earth_rate * rounding);
  RC_ASSERT(std::abs(m.force.dot(m.rate) - 9.8 * earth_rate * std::sin(latitude)) < 9.8 * earth_rate * rounding);
  RC_ASSERT(body.rate_nb_b.norm() + body.angular_acceleration_nb_b.norm() == 0);
}

}  // namespace
}  // namespace imulab
