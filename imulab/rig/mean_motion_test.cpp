#include "imulab/rig/mean_motion.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/table_steps.hpp"
#include <cmath>

namespace imulab {
namespace {

using unit::deg;

struct Means {
  std::array<std::vector<double>, 3> rate, force;
  Means(const MeanMotion& mean, std::size_t count, double interval) {
    MotionColumns out;
    for (std::size_t a = 0; a < 3; ++a) {
      rate[a].resize(count), force[a].resize(count);
      out.rate[a] = rate[a], out.force[a] = force[a];
    }
    mean.over(0, interval, out);
  }
  Vector3d rate_at(std::size_t k) const { return {rate[0][k], rate[1][k], rate[2][k]}; }
  Vector3d force_at(std::size_t k) const { return {force[0][k], force[1][k], force[2][k]}; }
};

/// A hold, a fast move of all axes, a rotation with ramps; the joints fall inside samples.
RigMotion lively() {
  return rig_motion(std::vector{hold_between(0, 0.5013, 10, 20, 30), hold_between(2.0031, 2.2, 190, -60, -100),
                                rotation_between(2.3007, 3.6007, RigAxis::middle, 180, 180)});
}

Surroundings surroundings() {
  Surroundings s{.rate_ie_n = earth_rate_enu(40 * deg), .gravity = 9.8};
  s.lever_arm << 0.05, -0.02, 0.03, -0.01, 0.04, 0.02, 0.03, 0.01, -0.05;
  return s;
}

/// Mean over (t0, t1) by Simpson's rule with 400 steps between the motion's joints.
Motion fine_mean(const RigMotion& motion, const Surroundings& around, double t0, double t1) {
  Motion sum;
  for (const MotionPiece& piece : motion.pieces) {
    const double a = std::max(t0, piece.begin), b = std::min(t1, piece.end);
    if (a >= b) continue;
    const int n = 400;
    for (int k = 0; k <= n; ++k) {
      const Motion m = sensed_motion(turntable_state(motion.axes, axis_states(piece, a + (b - a) * k / n)), around);
      const double w = (b - a) / (3 * n) * (k == 0 || k == n ? 1 : k % 2 ? 4 : 2);
      sum.force += w * m.force;
      sum.rate += w * m.rate;
    }
  }
  return {.rate = sum.rate / (t1 - t0), .force = sum.force / (t1 - t0)};
}

TEST(MeanMotion, QuadratureErrorIsBelow1e10OfFullScale) {
  const RigMotion motion = lively();
  for (const double interval : {0.01, 0.1, 0.7}) {
    const auto count = static_cast<std::size_t>(motion.end() / interval);
    const Means means(MeanMotion(motion, surroundings()), count, interval);
    for (std::size_t k = 0; k < count; ++k) {
      const Motion fine = fine_mean(motion, surroundings(), k * interval, (k + 1) * interval);
      // Full scale: 500 deg/s and 3 g. Simpson's own error is far below: (0.7 s / 400)^4 / 180 of a fourth derivative of 1e3.
      EXPECT_LT((means.rate_at(k) - fine.rate).norm(), 1e-10 * 500 * deg) << k;
      EXPECT_LT((means.force_at(k) - fine.force).norm(), 1e-10 * 3 * unit::g) << k;
    }
  }
}

TEST(MeanMotion, AtRestEverySampleIsTheSame) {
  const RigMotion motion = rig_motion(std::vector{hold_between(0, 10, 10, 20, 30)});
  const Means means(MeanMotion(motion, surroundings()), 1000, 0.01);
  const Motion still = sensed_motion(body_state(motion, 5), surroundings());
  for (std::size_t k = 0; k < 1000; ++k) {
    // A sample on the joint is an integral over its width: one rounding.
    EXPECT_LT((means.rate_at(k) - still.rate).norm(), 1e-19);
    EXPECT_LT((means.force_at(k) - still.force).norm(), 1e-14);
  }
}

// The independent path: the mean rates, integrated as rotation vectors, must turn the first attitude into the last one.
TEST(MeanMotion, IntegratedRatesAreTheAttitude) {
  const RigMotion motion = lively();
  const auto error = [&](double rate_hz) {
    const auto count = static_cast<std::size_t>(std::llround(3.6 * rate_hz));
    const Means means(MeanMotion(motion, surroundings()), count, 1 / rate_hz);
    Matrix3d C_ib = body_state(motion, 0).C_nb;
    for (std::size_t k = 0; k < count; ++k) C_ib = C_ib * rotation_exp(means.rate_at(k) / rate_hz);
    const Matrix3d C_in = rotation_exp(earth_rate_enu(40 * deg) * 3.6);
    return rotation_log(C_ib.transpose() * C_in * body_state(motion, 3.6).C_nb).norm();
  };
  // Means alone leave the commutator of the rate's change in a step, of second order: |w x w'| dt^2 / 12 per second, with up to 4 rad/s and
  // 8 rad/s^2 for 1.5 s, 4e-8 rad at 10 kHz.
  EXPECT_LT(error(10000), 4e-8);
  EXPECT_NEAR(error(500) / error(1000), 4, 0.2);  // second order; the rest is the next order and the joints
}

// With one common lever arm the force integrates to the velocity C (w x r), ramps or none: at an instantaneous start the rate jumps.
TEST(MeanMotion, IntegratedForceIsTheVelocityOfTheLeverArm) {
  Surroundings around{.rate_ie_n = Vector3d::Zero(), .gravity = 9.8};
  const Vector3d r(0.05, -0.02, 0.03);
  for (int i = 0; i < 3; ++i) around.lever_arm.row(i) = r;
  for (const double end : {3.0, 3.5}) {  // without ramps, and with ramps of 0.5 s; joints on samples' bounds, where a jump must count once
    const RigMotion motion =
        rig_motion(std::vector{hold_between(0, 1, 10, 20, 30), rotation_between(1, end, RigAxis::inner, 60, 30), hold_between(end, 5, 10, 20, 90)});
    const double rate_hz = 2000;
    const Means means(MeanMotion(motion, around), 10000, 1 / rate_hz);
    Vector3d v = Vector3d::Zero();
    const auto integrate = [&](std::size_t begin, std::size_t stop) {
      for (std::size_t k = begin; k < stop; ++k)
        v += body_state(motion, (k + 0.5) / rate_hz).C_nb * means.force_at(k) / rate_hz - Vector3d(0, 0, around.gravity / rate_hz);
    };
    const auto expect = [&](double t) {
      const BodyState body = body_state(motion, t);
      // The attitude at the middle of a sample in place of the mean of C f: a jump of 0.03 m/s at a sample's edge is turned wrongly by half a
      // sample, 30 deg/s / 4000; the rest is of second order.
      EXPECT_LT((v - body.C_nb * body.rate_nb_b.cross(r)).norm(), 0.03 * 30 * deg / 4000 * 2);
    };
    integrate(0, 4000), expect(2.0);
    integrate(4000, 10000), expect(5.0);
  }
}

}  // namespace
}  // namespace imulab
