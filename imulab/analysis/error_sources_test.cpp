#include "imulab/analysis/error_sources.hpp"

#include "imulab/model/coefficient.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

double sigma_of(const ErrorSources& s, std::string_view name) {
  const auto found = std::find(s.coefficients.begin(), s.coefficients.end(), coefficient_index(name));
  if (found == s.coefficients.end()) return 0;
  const auto k = found - s.coefficients.begin();
  return std::sqrt(s.covariance(k, k));
}

TEST(ErrorSources, AGradesAreWhatASimulationDraws) {
  const Grade& g = grade("mems");
  const ErrorSources s = sources_of(g);
  EXPECT_EQ(s.coefficients.size(), 3u + 9 + 9 + 3 + 6);  // of the accelerometers' matrix the lower triangle: the body's axes are theirs
  EXPECT_TRUE(s.fixed.isZero(0));
  EXPECT_DOUBLE_EQ(sigma_of(s, "gyro.offset.y"), g.gyro_bias);
  EXPECT_DOUBLE_EQ(sigma_of(s, "gyro.matrix.zz"), g.gyro_scale);
  EXPECT_DOUBLE_EQ(sigma_of(s, "gyro.matrix.xz"), g.gyro_misalignment);
  EXPECT_DOUBLE_EQ(sigma_of(s, "gyro.g_sensitivity.xx"), g.g_sensitivity);
  EXPECT_DOUBLE_EQ(sigma_of(s, "accel.offset.z"), g.accel_bias);
  EXPECT_DOUBLE_EQ(sigma_of(s, "accel.matrix.yy"), g.accel_scale);
  EXPECT_DOUBLE_EQ(sigma_of(s, "accel.matrix.zx"), g.accel_misalignment);
  EXPECT_EQ(sigma_of(s, "accel.matrix.xz"), 0);
  EXPECT_EQ(s.gyro_noise, g.gyro_noise);
}

TEST(ErrorSources, ACalibrationLeavesItsCovarianceButLeverArms) {
  Calibration c;
  c.model.accel.offset = {1, 2, 3};
  c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("accel.lever_arm.xx"), coefficient_index("gyro.offset.z")};
  c.covariance.resize(3, 3);
  c.covariance << 4, 1, 0.5, 1, 9, 2, 0.5, 2, 16;
  const ErrorSources s = sources_of(c);
  EXPECT_EQ(s.coefficients, (std::vector<int>{c.estimated[0], c.estimated[2]}));
  EXPECT_EQ(s.covariance, (Eigen::Matrix2d() << 4, 0.5, 0.5, 16).finished());
  EXPECT_EQ(s.fixed.size(), 2);
  EXPECT_EQ(s.model.accel.offset, c.model.accel.offset);
}

}  // namespace
}  // namespace imulab
