#include "imulab/estimate/drive/coefficients.hpp"

#include "imulab/coefficient.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

// The data determine x + 0.1 c with sigma 1e-3, and the prior of c is 1e-3: c keeps its prior, and a c of the same unit shifts x by -0.1 c again.
TEST(DriveCoefficients, WhatTheSameUnitHasAgainIsAPartOfTheCovariance) {
  constexpr double data = 1e-3, prior = 1e-3, slope = 0.1;
  AidedNavigation n;
  n.constants = {{"accel.offset.x", 0, 0, 1}, {"effect.accel.asymmetry.0", 0, prior, prior}};
  n.constants_covariance.resize(2, 2);
  n.constants_covariance << data * data + slope * slope * prior * prior, -slope * prior * prior, -slope * prior * prior, prior * prior;
  n.constants[0].sigma = std::sqrt(n.constants_covariance(0, 0));
  const Calibration c = drive::calibration_of(n).calibration;
  ASSERT_EQ(c.estimated, select_coefficients("accel.offset.x"));
  EXPECT_NEAR(c.covariance(0, 0), n.constants_covariance(0, 0), 1e-12 * data * data);
  ASSERT_EQ(c.constant_covariance.size(), 1);
  EXPECT_NEAR(c.constant_covariance(0, 0), slope * slope * prior * prior, 1e-12 * data * data);
}

}  // namespace
}  // namespace imulab
