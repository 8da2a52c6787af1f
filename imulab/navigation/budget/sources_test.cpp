#include "imulab/coefficient.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(ErrorSources, ACalibrationLeavesItsCovarianceButLeverArms) {
  Calibration c;
  c.model.accel.offset = {1, 2, 3};
  c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("accel.lever_arm.xx"), coefficient_index("gyro.offset.z")};
  c.covariance.resize(3, 3);
  c.covariance << 4, 1, 0.5, 1, 9, 2, 0.5, 2, 16;
  const ErrorSources s = error_sources(c);
  EXPECT_EQ(s.coefficients, (std::vector<CoefficientIndex>{c.estimated[0], c.estimated[2]}));
  EXPECT_EQ(s.covariance, (Eigen::Matrix2d() << 4, 0.5, 0.5, 16).finished());
  EXPECT_EQ(s.fixed.size(), 2);
  EXPECT_EQ(s.model.accel.offset, c.model.accel.offset);
}

}  // namespace
}  // namespace imulab
