#include "imulab/procedure.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

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
  const RigMotion m = rig_motion(s.steps_of(s.recordings.at(0)));
  EXPECT_EQ(m.pieces.size(), 12u + 11u);
  for (std::size_t k = 1; k < s.steps.size(); ++k)
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_LE(std::abs(s.steps[k].angles[a] - s.steps[k - 1].angles[a]), std::numbers::pi + 1e-9);  // the shorter direction; decimal degrees
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

Matrix3d attitude(const std::array<double, 3>& angles) {
  return turntable_state(ideal_axes(), {AxisState{angles[0], 0, 0}, AxisState{angles[1], 0, 0}, AxisState{angles[2], 0, 0}}).C_nb;
}

/// The direction of body axis `axis`: +1 up, -1 down, near 0 level.
double up(const Step& hold, int axis) { return attitude(hold.angles)(2, axis); }

TEST(SixPositionProcedure, EachAxisIsUpAndDownOnce) {
  const Session s = six_position_procedure({});
  ASSERT_EQ(s.steps.size(), 6u);
  const int axis[] = {2, 1, 0, 2, 1, 0};
  const double way[] = {1, 1, -1, -1, -1, 1};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(up(s.steps[k], axis[k]), way[k], 1e-15) << k;
  rig_motion(s.steps_of(s.recordings.at(0)));
}

TEST(Zhang24Procedure, HasTheTurnsAndTheFacesAtFourHeadings) {
  const Session s = zhang_24_procedure({});
  ASSERT_EQ(s.steps.size(), 1u + 12u + 24u);
  for (std::size_t k = 1; k < 13; k += 2) {
    EXPECT_EQ(s.steps[k].kind, StepKind::rotate);
    EXPECT_NEAR(std::abs(s.steps[k].angle), 10 * std::numbers::pi, 1e-14);
    EXPECT_DOUBLE_EQ(s.steps[k].end - s.steps[k].start, 180.2);
    EXPECT_NEAR(s.steps[k].angle + s.steps[k % 4 == 1 ? k + 2 : k - 2].angle, 0, 1e-14);  // forward, then back
  }
  const int enu_of_zhang[3] = {1, 2, 0};  // his x north, y up, z east
  for (std::size_t k = 0; k < 24; ++k) {
    const Step& hold = s.steps[13 + k];
    const std::size_t face = k / 4;
    EXPECT_NEAR(up(hold, enu_of_zhang[face % 3]), face < 3 ? 1 : -1, 1e-15);
    EXPECT_NEAR(hold.angles[0], static_cast<double>(k % 4) * std::numbers::pi / 2, 1e-15);
  }
  rig_motion(s.steps_of(s.recordings.at(0)));
}

TEST(ChengPathProcedure, EndsAsThePathSays) {
  const Session s = cheng_path_procedure({});
  ASSERT_EQ(s.steps.size(), 41u);
  const auto commands = commands_of(s.steps);
  // Sums of the path's turns: middle 90+180+180-90+90+180+180-90+90+90, inner 90+180+180-90-90+90-90, outer 90+90-90.
  const double sums[] = {90, 900, 270};
  for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(commands.back().after[a], sums[a] * unit::deg, 1e-12);
  // 21 rests of a minute, and 20 turns at 10 deg/s: 2430 deg, each with 0.2 s of ramps: 25 min.
  double way = 0;
  for (const Step& step : s.steps) way += std::abs(step.angle);
  EXPECT_NEAR(s.steps.back().end, 21 * 60 + way / (10 * unit::deg) + 20 * 0.2, 1e-9);
  rig_motion(s.steps_of(s.recordings.at(0)));
}

TEST(TurntableProcedures, RefuseWhatMakesNoSense) {
  for (const auto procedure : {six_position_procedure, zhang_24_procedure, cheng_path_procedure}) {
    EXPECT_THROW(procedure({.rest = 0}), Error);
    EXPECT_THROW(procedure({.turn_rate = 0}), Error);
    EXPECT_THROW(procedure({.turns = 0}), Error);
    EXPECT_THROW(procedure({.rate_hz = -1}), Error);
  }
}

TEST(DaiUnitProcedure, HasThePapersPoints) {
  const Session s = dai_unit_procedure({});
  ASSERT_EQ(s.recordings.size(), 3u);
  const std::vector<Step> chamber = s.steps_of(s.recordings[0]), table = s.steps_of(s.recordings[1]), arm = s.steps_of(s.recordings[2]);
  ASSERT_EQ(chamber.size(), 15u);
  ASSERT_EQ(table.size(), 246u);
  ASSERT_EQ(arm.size(), 42u);
  for (std::size_t k = 1; k < 15; ++k) EXPECT_GE(chamber[k].start - chamber[k - 1].end, 1800) << k;
  EXPECT_EQ(chamber.back().temperature, 70);
  for (std::size_t k = 0; k < 246; ++k) EXPECT_NEAR(table[k].rate / unit::deg, -400.0 + 20.0 * static_cast<double>(k % 41), 1e-9);
  std::vector<std::string> up, outward;
  for (std::size_t k = 0; k < 246; k += 41) up.push_back(mount_name(*table[k].mount).substr(0, 2));
  for (std::size_t k = 0; k < 42; k += 7) outward.push_back(mount_name(*arm[k].mount).substr(2));
  EXPECT_EQ(up, (std::vector<std::string>{"+x", "+y", "+z", "-x", "-y", "-z"}));
  EXPECT_EQ(outward, up);
  for (std::size_t k = 0; k < 42; ++k) {
    if (k % 7 == 0) {
      EXPECT_EQ(arm[k].kind, StepKind::hold);
      continue;
    }
    EXPECT_LT(arm[k].rate, 400 * unit::deg);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(arm[k].rate * arm[k].rate * 6.1, 5 * unit::g * static_cast<double>(k % 7),
                  0.013);  // rates in hundredths: 2 r w 0.005 deg/s and less
      const std::size_t opposite = (k + 21) % 42;
      EXPECT_NE(arm[k].radius[i], arm[opposite].radius[i]);
      EXPECT_NEAR(arm[k].radius[i] + arm[opposite].radius[i], 2 * 6.1, 1e-12);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NO_THROW(recorded_motion(s, s.recordings[k]));
  EXPECT_THROW(dai_unit_procedure({.record = 0}), Error);
}

}  // namespace
}  // namespace imulab
