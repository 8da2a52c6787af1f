#include "imulab/analysis/compare.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

Eigen::MatrixXd draws(int rows, int columns, std::uint64_t stream) {
  const RandomStream random(20261121, stream);
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = random.normal(static_cast<std::uint64_t>(i));
  return m;
}

/// A unit in the accelerometers' frame: raw in counts, misaligned by about 1e-2.
SensorModel any_model() {
  SensorModel m;
  m.accel.offset = {0.1, -0.2, 0.05};
  m.accel.matrix << 0.01, 0, 0, 1e-4, 0.011, 0, -2e-4, 1e-4, 0.009;
  m.gyro.offset = {0.02, -0.01, 0.03};
  m.gyro.matrix << 2e-3, 1e-5, -2e-5, 3e-5, 2.1e-3, 1e-5, -1e-5, 2e-5, 1.9e-3;
  m.g_sensitivity = 1e-4 * draws(3, 3, 1);
  m.lever_arm = 0.05 * draws(3, 3, 2);
  return m;
}

std::vector<int> coefficients(std::initializer_list<const char*> selectors) {
  std::vector<int> out;
  for (const char* s : selectors)
    for (const int i : select_coefficients(s)) {
      const auto name = coefficient_table()[static_cast<std::size_t>(i)].name;
      if (name != "accel.matrix.xy" && name != "accel.matrix.xz" && name != "accel.matrix.yz") out.push_back(i);
    }
  return out;
}

/// Everything linear estimated, with relative standard uncertainties of about 1e-5 and correlations.
Calibration any_calibration(std::uint64_t stream) {
  Calibration c;
  c.model = any_model();
  c.estimated = coefficients({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  const auto n = static_cast<int>(c.estimated.size());
  Eigen::VectorXd size(n);
  for (int i = 0; i < n; ++i) size(i) = 1e-5 * std::max(std::abs(coefficient_value(c.model, c.estimated[static_cast<std::size_t>(i)])), 1e-5);
  const Eigen::MatrixXd l = size.asDiagonal() * (Eigen::MatrixXd::Identity(n, n) + 0.3 * draws(n, n, stream));
  c.covariance = l * l.transpose();
  return c;
}

const CoefficientDifference& find(const Comparison& comparison, std::string_view name) {
  for (const auto& d : comparison.coefficients)
    if (coefficient_table()[static_cast<std::size_t>(d.index)].name == name) return d;
  throw Error("not compared: " + std::string(name));
}

TEST(Compare, EqualCalibrationsDoNotDiffer) {
  const Calibration a = any_calibration(3);
  const Comparison same = compare(a, a);
  ASSERT_EQ(same.coefficients.size(), 3u + 6 + 3 + 9 + 9);
  for (const auto& d : same.coefficients) {
    EXPECT_EQ(d.difference, 0);
    EXPECT_EQ(d.sigmas(), 0);
    EXPECT_NEAR(*d.uncertainty, std::sqrt(2.0) * *standard_uncertainty(a, d.index), 1e-12 * *d.uncertainty);  // two independent equal errors
  }
  EXPECT_EQ(same.consistency.degrees_of_freedom, 30);
  EXPECT_NEAR(same.consistency.p_value, 1, 1e-12);
}

TEST(Compare, MatricesDifferInPpmAndArcsec) {
  Calibration a = any_calibration(3), b = a;
  Matrix3d d;  // M_b M_a^-1 - I, whatever the raw unit
  d << 20e-6, 5 * unit::arcsec, -7 * unit::arcsec, 3 * unit::arcsec, -10e-6, 2 * unit::arcsec, 1 * unit::arcsec, -4 * unit::arcsec, 30e-6;
  b.model.gyro.matrix = a.model.gyro.matrix + d * a.model.gyro.matrix;
  const Comparison comparison = compare(a, b);
  // The sums leave 1e-16 relative to 1, which is 1e-10 ppm.
  EXPECT_NEAR(find(comparison, "gyro.matrix.xx").user_difference, 20, 1e-9);
  EXPECT_EQ(find(comparison, "gyro.matrix.xx").user_unit, "ppm");
  EXPECT_NEAR(find(comparison, "gyro.matrix.xy").user_difference, 5, 1e-9);
  EXPECT_EQ(find(comparison, "gyro.matrix.xy").user_unit, "arcsec");
  EXPECT_NEAR(find(comparison, "gyro.matrix.zy").user_difference, -4, 1e-9);
  EXPECT_DOUBLE_EQ(find(comparison, "gyro.matrix.xy").difference, b.model.gyro.matrix(0, 1) - a.model.gyro.matrix(0, 1));
}

TEST(Compare, OtherTermsDifferInTheirOwnUnits) {
  Calibration a = any_calibration(3), b = a;
  b.model.accel.offset.x() += 30 * unit::ug;
  b.model.gyro.offset.z() -= 0.5 * unit::deg_per_h;
  b.model.g_sensitivity(2, 0) += 2 * unit::deg_per_h / unit::g;
  b.model.lever_arm(0, 1) += 0.004;
  b.model.gyro.cubic.y() = 1e-9;
  const Comparison small = compare(a, b);
  EXPECT_NEAR(find(small, "accel.offset.x").user_difference, 30, 1e-9);  // 0.1 m/s^2 holds 1e-16: 1e-12 ug
  EXPECT_NEAR(find(small, "gyro.offset.z").user_difference, -0.5, 1e-9);
  EXPECT_NEAR(find(small, "gyro.g_sensitivity.zx").user_difference, 2, 1e-9);
  EXPECT_NEAR(find(small, "accel.lever_arm.xy").user_difference, 4, 1e-9);
  EXPECT_FALSE(find(small, "accel.lever_arm.xy").sigmas()) << "neither calibration estimated it";
  EXPECT_EQ(find(small, "gyro.cubic.y").user_difference, 1e-9);
  EXPECT_EQ(find(small, "gyro.cubic.y").user_unit, "(rad/s)/raw^3");
  EXPECT_THROW(find(small, "gyro.cubic.x"), Error) << "not estimated, and equal";

  b.model.accel.offset.x() += 0.5;
  b.model.gyro.offset.z() += 0.1;
  const Comparison large = compare(a, b);
  EXPECT_EQ(find(large, "accel.offset.x").user_unit, "mg");
  EXPECT_EQ(find(large, "accel.offset.y").user_unit, "mg") << "the axes of a term share a unit";
  EXPECT_EQ(find(large, "gyro.offset.z").user_unit, "deg/s");
}

TEST(Compare, SigmasUseBothCovariancesAndOnlyTheCalibrationsAgainstATruth) {
  Calibration a = any_calibration(3), b = any_calibration(4), truth;
  truth.model = any_model();
  truth.model.gyro.offset.x() += 1e-6;
  b.model = truth.model;
  const int x = coefficient_index("gyro.offset.x");
  const double ua = *standard_uncertainty(a, x), ub = *standard_uncertainty(b, x);
  EXPECT_NEAR(*find(compare(a, truth), "gyro.offset.x").sigmas(), 1e-6 / ua, 1e-9 * 1e-6 / ua);
  EXPECT_NEAR(*find(compare(truth, a), "gyro.offset.x").sigmas(), -1e-6 / ua, 1e-9 * 1e-6 / ua);
  EXPECT_NEAR(*find(compare(a, b), "gyro.offset.x").sigmas(), 1e-6 / std::hypot(ua, ub), 1e-9 * 1e-6 / ua);
  EXPECT_EQ(compare(truth, truth).consistency.degrees_of_freedom, 0);
}

TEST(Compare, PooledConsistencyIsTheMahalanobisDistance) {
  const Calibration a = any_calibration(3);
  Calibration b = any_calibration(4);
  Eigen::VectorXd e(a.estimated.size());
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    e(i) = 1e-5 * draws(1, 30, 5)(i) * std::sqrt(a.covariance(i, i)) * 1e5;
    const int at = a.estimated[static_cast<std::size_t>(i)];
    set_coefficient(b.model, at, coefficient_value(a.model, at) + e(i));
  }
  const Consistency c = compare(a, b).consistency;
  const double expected = e.dot((a.covariance + b.covariance).ldlt().solve(e));
  EXPECT_EQ(c.degrees_of_freedom, 30);
  EXPECT_NEAR(c.chi2, expected, 1e-6 * expected);  // e is a difference of values 1e5 times larger; the condition adds two digits
  EXPECT_NEAR(c.p_value, chi_square_tail(expected, 30), 1e-5);
}

TEST(Compare, TestsOnlyWhatBothEstimated) {
  Calibration a = any_calibration(3), b;
  b.model = a.model;
  b.estimated = coefficients({"gyro.offset", "accel.thermal"});
  b.covariance = 1e-12 * Eigen::MatrixXd::Identity(9, 9);
  const Comparison comparison = compare(a, b);
  EXPECT_EQ(comparison.consistency.degrees_of_freedom, 3);
  EXPECT_EQ(comparison.coefficients.size(), 30u + 6);
}

/// The same calibration stated in a rig's frame: a' = F a with a fixed F.
Calibration in_frame(const Calibration& c, const Matrix3d& f) {
  const auto turned = [&](SensorModel m) {
    m.accel.offset = f * m.accel.offset;
    m.accel.matrix = f * m.accel.matrix;
    m.gyro.offset = f * m.gyro.offset;
    m.gyro.matrix = f * m.gyro.matrix;
    m.g_sensitivity = f * m.g_sensitivity * f.transpose();
    m.lever_arm = m.lever_arm * f.transpose();
    return m;
  };
  Calibration out = c;
  out.frame = "rig";
  out.model = turned(c.model);
  out.estimated.clear();
  for (const char* s : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const int i : select_coefficients(s)) out.estimated.push_back(i);
  Eigen::MatrixXd jacobian(out.estimated.size(), c.estimated.size());  // the map is linear: its columns are images of unit vectors
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    SensorModel unit;
    for (int i = 0; i < coefficient_count; ++i) set_coefficient(unit, i, 0);
    set_coefficient(unit, c.estimated[k], 1);
    const SensorModel image = turned(unit);
    for (std::size_t i = 0; i < out.estimated.size(); ++i)
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = coefficient_value(image, out.estimated[i]);
  }
  out.covariance = jacobian * c.covariance * jacobian.transpose();
  return out;
}

TEST(Compare, DoesNotDependOnTheFramesTheCalibrationsAreStatedIn) {
  const Calibration a = any_calibration(3);
  Calibration b = any_calibration(4);
  for (std::size_t k = 0; k < b.estimated.size(); ++k) {
    const int at = b.estimated[k];
    const auto i = static_cast<Eigen::Index>(k);
    set_coefficient(b.model, at, coefficient_value(b.model, at) + std::sqrt(b.covariance(i, i)) * draws(1, 30, 6)(i));
  }
  const Comparison here = compare(a, b);
  const Comparison there = compare(in_frame(a, rotation_exp({0.5, -0.3, 1.2})), in_frame(b, rotation_exp({-2, 0.1, 0.4})));
  ASSERT_EQ(here.coefficients.size(), 30u);
  for (const auto& d : here.coefficients) {
    const auto name = coefficient_table()[static_cast<std::size_t>(d.index)].name;
    // Differences are 1e-5 of the values, smaller yet against the vector they are rotated with: five to six digits of sixteen are lost.
    EXPECT_NEAR(*find(there, name).sigmas(), *d.sigmas(), 1e-5 * (1 + std::abs(*d.sigmas()))) << name;
    EXPECT_NEAR(*find(there, name).user_sigmas(), *d.user_sigmas(), 1e-5 * (1 + std::abs(*d.user_sigmas()))) << name;
  }
  EXPECT_EQ(there.consistency.degrees_of_freedom, 30);
  EXPECT_NEAR(there.consistency.chi2, here.consistency.chi2, 1e-4 * here.consistency.chi2);
}

TEST(Compare, ErrorsDrawnFromTheStatedCovarianceAreConsistent) {
  const Calibration truth = [] {
    Calibration t;
    t.model = any_model();
    return t;
  }();
  const Calibration stated = any_calibration(3);
  const Eigen::MatrixXd l = stated.covariance.llt().matrixL();
  constexpr int runs = 200;
  double chi2 = 0;
  int dof = 0;
  for (int run = 0; run < runs; ++run) {
    const Eigen::VectorXd e = l * draws(30, 1, 100 + static_cast<std::uint64_t>(run));
    Calibration drawn = stated;
    for (std::size_t k = 0; k < stated.estimated.size(); ++k)
      set_coefficient(drawn.model, stated.estimated[k], coefficient_value(truth.model, stated.estimated[k]) + e(static_cast<Eigen::Index>(k)));
    const Consistency c = compare(drawn, truth).consistency;
    chi2 += c.chi2;
    dof += c.degrees_of_freedom;
  }
  EXPECT_EQ(dof, 30 * runs);
  EXPECT_GT(chi2, chi_square_quantile(0.0005, dof));  // the 99.9 % band of 6000 degrees of freedom
  EXPECT_LT(chi2, chi_square_quantile(0.9995, dof));
}

TEST(Compare, ASingularMatrixIsAnError) {
  Calibration a = any_calibration(3);
  a.model.gyro.matrix.setZero();
  EXPECT_THROW(compare(a, any_calibration(3)), Error);
}

}  // namespace
}  // namespace imulab
