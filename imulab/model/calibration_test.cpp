#include "imulab/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

TEST(Calibration, RawZeroIsWhereTheOutputVanishes) {
  Calibration c;
  c.model.gyro.matrix << 2e-4, 1e-6, -2e-6, 3e-6, 2.1e-4, 0, 1e-6, 2e-6, 1.9e-4;
  const Vector3d zero(32768, 32466, 32485);
  c.model.gyro.offset = -c.model.gyro.matrix * zero;
  c.estimated = select_coefficients("gyro.offset");
  c.covariance = 1e-8 * Eigen::Matrix3d::Identity();
  const RawZero found = raw_zero(c, Triad::gyro);
  EXPECT_LT((found.value - zero).norm(), 1e-8);
  // If only the offsets are uncertain, dB = -W1^-1 dW0: 1e-4 / 2e-4 counts, up to the squared misalignment.
  EXPECT_NEAR(found.uncertainty.x(), 0.5, 1e-3);
  EXPECT_TRUE(std::isnan(raw_zero(c, Triad::accel).uncertainty.x()));
}

TEST(Calibration, RawZeroKnowsThatOffsetAndScaleErrAsOne) {
  // Offset and scale are determined at readings around N: the zero is much more certain than the offset at raw zero.
  Calibration c;
  const double n = 32768, scale = 2e-4;
  c.model.accel.matrix = scale * Matrix3d::Identity();
  c.model.accel.offset = Vector3d::Constant(-scale * n);
  c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("accel.matrix.xx")};
  const double bias_sigma = 1e-3, scale_sigma = 1e-8;  // independent at the center: dA0 = d bias - n d scale
  c.covariance.resize(2, 2);
  c.covariance << bias_sigma * bias_sigma + n * n * scale_sigma * scale_sigma, -n * scale_sigma * scale_sigma, -n * scale_sigma * scale_sigma,
      scale_sigma * scale_sigma;
  EXPECT_NEAR(raw_zero(c, Triad::accel).uncertainty.x(), bias_sigma / scale, 1e-6);
}

}  // namespace
}  // namespace imulab
