#include "imulab/recording/turn.hpp"
#include "imulab/rig/pose_on_table.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace imulab {
namespace {

using enum RigAxis;

TEST(QuarterTable, HasTheAttitudesAndAxesOfTheTable) {
  const QuarterTable table;
  EXPECT_EQ(table.attitudes().size(), 24u);
  for (int p = 0; p < 64; ++p) {
    const QuarterPose pose{p / 16, p / 4 % 4, p % 4};
    for (std::size_t a = 0; a < 3; ++a) {
      AxisStates states;
      for (std::size_t b = 0; b < 3; ++b) states[b].angle = pose[b] * std::numbers::pi / 2;
      states[a].rate = 1;
      const BodyState body = turntable_state(ideal_axes(), states);
      EXPECT_LT((body.C_nb - table.attitudes()[table.attitude(pose)]).norm(), 1e-14);
      const auto [along, opposite] = table.axis(pose, static_cast<RigAxis>(a));
      const Vector3d axis = (opposite ? -1 : 1) * Vector3d::Unit(static_cast<Eigen::Index>(along));
      EXPECT_LT((body.C_nb * body.rate_nb_b - axis).norm(), 1e-14);
    }
  }
}

TEST(PoseOnTable, EndsWhereTheTurnsDo) {
  const std::vector<TableTurn> turns{{middle, 90, 10}, {outer, 180, 10}, {inner, -90, 10}};
  PoseOnTable pose;
  for (const TableTurn& turn : turns) pose = turned(pose, turn);
  const PoseOnTable end = pose_at_end(turns_procedure("turns", 10, turns, {}).steps);
  EXPECT_LT((pose.C_nb - end.C_nb).norm(), 1e-9);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_LT((pose.axes[a] - end.axes[a]).norm(), 1e-9);
}

TEST(PoseOnTable, ATurnIsNamedByTheBodysAxis) {
  EXPECT_THAT(in_words(std::vector<TableTurn>{{outer, 90, 10}, {middle, -90, 10}, {outer, 180, 10}}),
              testing::ElementsAre("turn by 90 deg about the IMU's z axis while it is vertical",
                                   "turn by -90 deg about the IMU's y axis while it is horizontal",
                                   "turn by 180 deg about the IMU's x axis while it is vertical"));
}

TEST(TurnState, RampsCruisesAndArrives) {
  for (const double angle : {-1.5, 0.02, 3.0}) {
    const double rate = 0.2, acceleration = 0.9, duration = turn_duration(angle, rate, acceleration), step = 1e-4;
    EXPECT_EQ(turn_state(angle, rate, acceleration, -1).angle, 0);
    EXPECT_NEAR(turn_state(angle, rate, acceleration, duration).angle, angle, 1e-12);
    for (double t = 0; t < duration; t += 0.01) {
      const TurnState before = turn_state(angle, rate, acceleration, t), after = turn_state(angle, rate, acceleration, t + step);
      EXPECT_NEAR(after.angle - before.angle, 0.5 * step * (before.rate + after.rate), acceleration * step * step);  // also across a corner
      EXPECT_LE(std::abs(before.rate), rate * (1 + 1e-12));
    }
  }
}

}  // namespace
}  // namespace imulab
