#include "imulab/rig/procedure.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/rig/motion.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace imulab {
namespace {

TEST(HandHeldProcedure, HasTheRestsAndTimesAskedFor) {
  const HandHeldOptions options{.poses = 12, .first_rest = 20, .rest = 3, .move = 1.5};
  const Session s = hand_held_procedure(options, 1);
  ASSERT_EQ(s.steps.size(), 12u);
  EXPECT_DOUBLE_EQ(s.steps.back().end, 20 + 11 * (3 + 1.5));
  EXPECT_EQ(s.rigs.at(0).kind, RigKind::none);
  const RigMotion m = rig_motion(steps_of(s, s.recordings.at(0)));
  EXPECT_EQ(m.pieces.size(), 12u + 11u);
  for (std::size_t k = 1; k < s.steps.size(); ++k)
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_LE(std::abs(s.steps[k].angles[a] - s.steps[k - 1].angles[a]), std::numbers::pi + 1e-9);  // the short way; decimal degrees
}

TEST(HandHeldProcedure, AttitudesAreUniform) {
  const Session s = hand_held_procedure({.poses = 4000}, 1);
  // Each element of a uniform attitude is uniform on (-1, 1) with variance 1/3 (Archimedes): mean square over n attitudes within
  // 5 sigma, sigma = sqrt((1/5 - 1/9) / n); mean within 5 sqrt(1/3 / n).
  const double n = 4000;
  Matrix3d mean = Matrix3d::Zero(), square = Matrix3d::Zero();
  for (const Step& step : s.steps) {
    const Matrix3d c = turntable_state(ideal_axes(), {AxisState{step.angles[0]}, AxisState{step.angles[1]}, AxisState{step.angles[2]}}).C_nb;
    mean += c / n;
    square += c.cwiseAbs2() / n;
  }
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 5 * std::sqrt(1.0 / 3 / n));
  EXPECT_LT((square.array() - 1.0 / 3).abs().maxCoeff(), 5 * std::sqrt((1.0 / 5 - 1.0 / 9) / n));
}

TEST(HandHeldProcedure, AnotherSeedIsAnotherPath) {
  const Session a = hand_held_procedure({}, 1), b = hand_held_procedure({}, 2), again = hand_held_procedure({}, 1);
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    EXPECT_NE(a.steps[k].angles, b.steps[k].angles);
    EXPECT_EQ(a.steps[k].angles, again.steps[k].angles);
  }
}

TEST(HandHeldProcedure, RefusesWhatMakesNoSense) {
  EXPECT_THROW(hand_held_procedure({.poses = 0}, 1), Error);
  EXPECT_THROW(hand_held_procedure({.rest = 0}, 1), Error);
  EXPECT_THROW(hand_held_procedure({.rate_hz = 0}, 1), Error);
}

}  // namespace
}  // namespace imulab
