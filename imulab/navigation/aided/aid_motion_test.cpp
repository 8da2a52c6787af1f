#include "imulab/navigation/aided/aid_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace imulab::aided {
namespace {

// The unit rests for 10 s, then moves with a constant force, which an IMU cannot distinguish from a rest.
TEST(AidMotion, ASteadyAccelerationIsNoRest) {
  Aid receiver, wheels{.kind = AidKind::wheels};
  for (int t = 0; t <= 20; ++t) {
    const double speed = std::max(0, t - 10);
    for (Aid* aid : {&receiver, &wheels}) aid->record.time.push_back(t * 1'000'000'000LL);
    receiver.record.velocity.emplace_back(speed, 0, 0), receiver.record.velocity_sigma.push_back(Eigen::Vector3d::Constant(0.05));
    wheels.record.value.push_back(speed), wheels.record.value_sigma.push_back(0.05);
  }
  for (const Aid& aid : {receiver, wheels}) {
    EXPECT_FALSE(any_moves({aid}, "a.csv", 0, 10));
    EXPECT_TRUE(any_moves({aid}, "a.csv", 11, 15));
    Aid of_another = aid;
    of_another.recording = "b.csv";
    EXPECT_FALSE(any_moves({of_another}, "a.csv", 11, 15));
  }
}

}  // namespace
}  // namespace imulab::aided
