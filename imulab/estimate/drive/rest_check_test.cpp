#include "imulab/estimate/drive/rest_check.hpp"

#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab::drive {
namespace {

constexpr double rate_hz = 100, turn_rate = 30 * unit::deg, gravity = 9.81;

/// Returns five seconds level, a roll of a quarter turn in three seconds, and five seconds on the side.
Recording rolled() {
  Recording r;
  r.interval_s = 1 / rate_hz;
  r.gyro_unit = "rad/s", r.accel_unit = "m/s^2";
  for (int k = 1; k <= 1300; ++k) {
    const double t = k / rate_hz, roll = turn_rate * std::clamp(t - 5, 0.0, 3.0), shake = 1e-4 * (k % 3 - 1);
    r.time_ns.push_back(std::llround(1e9 * t));
    r.gyro[0].push_back((t > 5 && t <= 8 ? turn_rate : 0) + shake), r.gyro[1].push_back(-shake), r.gyro[2].push_back(shake);
    r.accel[0].push_back(shake), r.accel[1].push_back(gravity * std::sin(roll) + shake), r.accel[2].push_back(gravity * std::cos(roll) - shake);
  }
  return r;
}

/// Returns a unit with u of 1 mm/s^2 for the accelerometers' offsets and 0.001 for the scale of the gyro about x.
Calibration unit_of(double accel_offset, double gyro_scale) {
  Calibration c;
  c.method = "drive";
  c.model.accel.raw_unit = "m/s^2", c.model.gyro.raw_unit = "rad/s";
  c.model.accel.offset.z() = accel_offset;
  c.model.gyro.matrix(0, 0) = gyro_scale;
  c.estimated = select_each({"accel.offset"});
  c.estimated.push_back(coefficient_index("gyro.matrix.xx"));
  c.covariance = 1e-6 * Eigen::MatrixXd::Identity(4, 4);
  return c;
}

std::vector<std::string> doubts_of(double accel_offset, double gyro_scale) {
  Session session;
  session.site.given_gravity = gravity;
  kernel::Findings findings;
  doubt_at_rest(unit_of(accel_offset, gyro_scale), {}, rolled(), session, "", findings);
  return findings.reasons();
}

TEST(DriveAtRest, WhatTheCovarianceExplainsIsNoDoubt) {
  EXPECT_THAT(doubts_of(0, 1), testing::IsEmpty());
  EXPECT_THAT(doubts_of(0.003, 1.003), testing::IsEmpty());  // three sigmas
}

TEST(DriveAtRest, AForceThatIsNotGravityIsADoubt) {
  EXPECT_THAT(doubts_of(0.008, 1), testing::ElementsAre(testing::HasSubstr("calibrated force is +0.816 mg from gravity, where 0.1 mg is its")));
}

TEST(DriveAtRest, ATurnThatDoesNotCarryGravityIsADoubt) {
  EXPECT_THAT(doubts_of(0, 1.008),
              testing::ElementsAre(testing::ContainsRegex("calibrated gyros miss gravity's turn by 0.7.* deg, where 0.0.* deg")));
}

}  // namespace
}  // namespace imulab::drive
