#include "imulab/calibration.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

Calibration with_scale(double u, double relative_g, int degrees_of_freedom) {
  Calibration c;
  c.estimated = select_coefficients("accel.matrix.xx");
  c.covariance = Eigen::MatrixXd::Constant(1, 1, u * u);
  c.quality.sources = {{"gravity", relative_g, ""}};
  c.quality.degrees_of_freedom = degrees_of_freedom;
  return c;
}

const CoefficientIndex scale = coefficient_index("accel.matrix.xx");

TEST(ExpandedUncertainty, CoverageFactorsOfTheGuide) {
  // JCGM 100, table G.2, 95.45 %.
  EXPECT_NEAR(student_quantile(0.5 * (1 + 0.9545), 10), 2.28, 0.005);
  EXPECT_NEAR(student_quantile(0.5 * (1 + 0.9545), 50), 2.05, 0.005);
  EXPECT_NEAR(student_quantile(0.5 * (1 + 0.9545), INFINITY), 2.00, 0.005);
}

TEST(ExpandedUncertainty, WithoutDeclaredPartTheFitHasIt) {
  const ExpandedUncertainty u = expanded_uncertainty(with_scale(3e-5, 0, 10), scale);
  EXPECT_EQ(u.declared, 0);
  EXPECT_NEAR(u.from_fit, 3e-5, 1e-15);
  EXPECT_NEAR(u.degrees_of_freedom, 10, 1e-9);
  EXPECT_NEAR(u.expanded, 2.28 * 3e-5, 2e-7);
}

TEST(ExpandedUncertainty, TheDeclaredPartAddsDegreesOfFreedom) {
  const ExpandedUncertainty u = expanded_uncertainty(with_scale(5e-5, 3e-5, 10), scale);  // 3-4-5
  EXPECT_NEAR(u.declared, 3e-5, 1e-15);
  EXPECT_NEAR(u.from_fit, 4e-5, 1e-15);
  EXPECT_NEAR(u.degrees_of_freedom, 10 / std::pow(0.8, 4), 1e-9);  // Welch-Satterthwaite
}

TEST(ExpandedUncertainty, WhatTheDataKnowBetterIsNotDeclared) { EXPECT_EQ(expanded_uncertainty(with_scale(1e-5, 3e-5, 10), scale).declared, 0); }

TEST(ExpandedUncertainty, ACoefficientWithoutUncertaintyIsRefused) {
  EXPECT_THROW(expanded_uncertainty(with_scale(1e-5, 0, 10), coefficient_index("gyro.offset.x")), Error);
}

}  // namespace
}  // namespace imulab
