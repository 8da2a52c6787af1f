#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace imulab {
namespace {

double angle(int low, int high) { return *rc::gen::inRange(low, high) * 1e-4; }

TEST(Attitude, TheAxesPointAsTheConventionsSay) {
  // 1e-15: rounding of a cosine of 90 deg.
  EXPECT_TRUE(attitude_matrix({}).isIdentity(0));
  EXPECT_LT((attitude_matrix({0, 0, 90 * unit::deg}).col(1) - Vector3d::UnitX()).norm(), 1e-15);  // heading east: forward is east
  EXPECT_GT(attitude_matrix({0, 0.1, 0})(2, 1), 0);                                               // pitch up: forward rises
  EXPECT_LT(attitude_matrix({0.1, 0, 0})(2, 0), 0);                                               // roll: the right side sinks
}

RC_GTEST_PROP(Attitude, AnglesComeBack, ()) {
  const EulerAngles a{angle(-31000, 31000), angle(-15000, 15000), angle(-31000, 31000)};
  const EulerAngles back = euler_angles(attitude_matrix(a));
  // The tolerance 1e-13 is rounding divided by the cosine of the steepest pitch, 0.07.
  RC_ASSERT(std::abs(back.roll - a.roll) + std::abs(back.pitch - a.pitch) + std::abs(back.heading - a.heading) < 1e-13);
}

RC_GTEST_PROP(Attitude, TheRateIsTheDerivativeOfTheMatrix, ()) {
  const EulerAngles a{angle(-31000, 31000), angle(-15000, 15000), angle(-31000, 31000)}, d{angle(-9, 9), angle(-9, 9), angle(-9, 9)};
  const double h = 1e-4;
  const auto at = [&](double t) { return attitude_matrix({a.roll + t * d.roll, a.pitch + t * d.pitch, a.heading + t * d.heading}); };
  // Central difference: (h d)^2 d and rounding over h, both below 1e-11.
  RC_ASSERT((rotation_log(at(-h).transpose() * at(h)) / (2 * h) - attitude_rate(a, d)).norm() < 1e-11);
}

}  // namespace
}  // namespace imulab
