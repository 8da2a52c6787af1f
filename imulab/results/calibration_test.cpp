#include "imulab/results/calibration.hpp"

#include "imulab/units.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

TEST(CalibrationSummary, StatesTheOffsetsOfTheNextSwitchOn) {
  Calibration c;
  for (const char* name : {"accel.offset.x", "accel.offset.y", "gyro.offset.z"}) c.estimated.push_back(coefficient_index(name));
  c.covariance = Eigen::Vector3d(30 * unit::ug, 40 * unit::ug, 2 * unit::deg_per_h).cwiseAbs2().asDiagonal();
  EXPECT_THAT(calibration_summary(c), testing::Not(testing::HasSubstr("switch-on")));
  c.next_switch_on = {{"accel.offset.x", 50 * unit::ug}, {"accel.offset.y", 75 * unit::ug}};
  EXPECT_EQ(next_switch_on_text(c), "accel.offset 75 ug");
  c.next_switch_on["gyro.offset.z"] = 20 * unit::deg_per_h;
  EXPECT_THAT(calibration_summary(c), testing::HasSubstr("\n  next switch-on  accel.offset 75 ug, gyro.offset 20 deg/h\n"));
}

}  // namespace
}  // namespace imulab
