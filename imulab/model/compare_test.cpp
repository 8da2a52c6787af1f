#include "imulab/compare.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include <cmath>
#include <tuple>

namespace imulab {
namespace {

Eigen::MatrixXd draws(int rows, int columns, std::uint64_t stream) {
  const RandomStream random(20261121, stream);
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = random.normal(static_cast<std::uint64_t>(i));
  return m;
}

/// Returns an IMU in the accelerometers' frame: raw in counts, misaligned by about 1e-2.
SensorModel model_of_counts() {
  SensorModel m;
  m.accel.offset = {0.1, -0.2, 0.05};
  m.accel.matrix << 0.01, 0, 0, 1e-4, 0.011, 0, -2e-4, 1e-4, 0.009;
  m.gyro.offset = {0.02, -0.01, 0.03};
  m.gyro.matrix << 2e-3, 1e-5, -2e-5, 3e-5, 2.1e-3, 1e-5, -1e-5, 2e-5, 1.9e-3;
  m.g_sensitivity = 1e-4 * draws(3, 3, 1);
  m.lever_arm = 0.05 * draws(3, 3, 2);
  return m;
}

std::vector<CoefficientIndex> coefficients(std::initializer_list<const char*> selectors) {
  std::vector<CoefficientIndex> out;
  for (const char* s : selectors)
    for (const CoefficientIndex i : select_coefficients(s)) {
      const auto name = coefficient(i).name;
      if (name != "accel.matrix.xy" && name != "accel.matrix.xz" && name != "accel.matrix.yz") out.push_back(i);
    }
  return out;
}

/// Returns a calibration with all linear terms estimated, relative standard uncertainties of about 1e-5, and correlations.
Calibration any_calibration(std::uint64_t stream) {
  Calibration c;
  c.model = model_of_counts();
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
    if (coefficient(d.index).name == name) return d;
  throw Error("not compared: " + std::string(name));
}

/// Calibrations of one unit have independent errors and recurring errors. Recurring ones cancel in differences, but not relative to the truth, to
/// another unit, or to another method.
TEST(Compare, WhatAUnitBringsAgainCancels) {
  Calibration a = any_calibration(3);
  a.imu = "unit", a.method = "static", a.serial = "1";
  const Eigen::Index n = a.covariance.rows();
  const Eigen::MatrixXd own = a.covariance;
  const Eigen::MatrixXd l = 10 * own.diagonal().cwiseSqrt().asDiagonal() * draws(static_cast<int>(n), 4, 7);
  a.constant_covariance = l * l.transpose();
  a.covariance = own + a.constant_covariance;
  const Eigen::MatrixXd root = own.llt().matrixL();
  double chi2 = 0, together = 0;
  constexpr int runs = 100;
  for (int run = 0; run < runs; ++run) {
    const RandomStream random(20261129, static_cast<std::uint64_t>(run));
    const auto normal = [&](Eigen::Index k) { return random.normal(static_cast<std::uint64_t>(k)); };
    const Eigen::VectorXd always = l * Eigen::VectorXd::NullaryExpr(4, [&](Eigen::Index k) { return normal(k); });
    std::vector<Calibration> all(3, a);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Eigen::VectorXd error =
          always + root * Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index i) { return normal(10 + 100 * (Eigen::Index(k)) + i); });
      for (Eigen::Index i = 0; i < n; ++i) {
        const CoefficientIndex index = a.estimated[static_cast<std::size_t>(i)];
        set_coefficient(all[k].model, index, coefficient_value(a.model, index) + error[i]);
      }
    }
    chi2 += compare(all[0], all[1]).consistency.chi2 / runs;
    together += agreement(all).consistency.chi2 / runs;
  }
  const double sigma = std::sqrt(2.0 * static_cast<double>(n) / runs);  // of the mean of chi-squares
  EXPECT_NEAR(chi2, static_cast<double>(n), 4 * sigma);
  EXPECT_NEAR(together, 2 * static_cast<double>(n), 4 * std::sqrt(2.0) * sigma);
  const auto uncertainty = [&](const char* serial, const char* method) {
    Calibration b = a;
    b.serial = serial, b.method = method;
    return *find(compare(a, b), "accel.offset.x").uncertainty;
  };
  EXPECT_NEAR(uncertainty("1", "static"), std::sqrt(2 * own(0, 0)), 1e-9 * std::sqrt(own(0, 0)));
  EXPECT_NEAR(uncertainty("2", "static"), std::sqrt(2 * a.covariance(0, 0)), 1e-9 * std::sqrt(own(0, 0)));
  EXPECT_NEAR(uncertainty("1", "handheld"), std::sqrt(2 * a.covariance(0, 0)), 1e-9 * std::sqrt(own(0, 0)));
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
  Matrix3d d;  // M_b M_a^-1 - I, for any raw unit
  d << 20e-6, 5 * unit::arcsec, -7 * unit::arcsec, 3 * unit::arcsec, -10e-6, 2 * unit::arcsec, 1 * unit::arcsec, -4 * unit::arcsec, 30e-6;
  b.model.gyro.matrix = a.model.gyro.matrix + d * a.model.gyro.matrix;
  const Comparison comparison = compare(a, b);
  // The rounding of the sums is 1e-16 relative to 1, or 1e-10 ppm.
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
  EXPECT_NEAR(find(small, "accel.offset.x").user_difference, 30, 1e-9);  // 0.1 m/s^2 has a rounding of 1e-16: 1e-12 ug
  EXPECT_NEAR(find(small, "gyro.offset.z").user_difference, -0.5, 1e-9);
  EXPECT_NEAR(find(small, "gyro.g_sensitivity.zx").user_difference, 2, 1e-9);
  EXPECT_NEAR(find(small, "accel.lever_arm.xy").user_difference, 4, 1e-9);
  EXPECT_FALSE(find(small, "accel.lever_arm.xy").sigmas()) << "neither calibration estimated it";
  EXPECT_NEAR(find(small, "gyro.cubic.y").user_difference, unit::deg * unit::deg, 1e-12) << "1e-9 of a rate of 1 rad/s";
  EXPECT_EQ(find(small, "gyro.cubic.y").user_unit, "ppb/(deg/s)^2");
  a.model.gyro.raw_unit = b.model.gyro.raw_unit = "count";
  EXPECT_EQ(find(compare(a, b), "gyro.cubic.y").user_difference, 1e-9);
  EXPECT_EQ(find(compare(a, b), "gyro.cubic.y").user_unit, "(rad/s)/raw^3") << "how large a count is nobody said";
  a.model.gyro.raw_unit = b.model.gyro.raw_unit = "rad/s";
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
  truth.model = model_of_counts();
  truth.model.gyro.offset.x() += 1e-6;
  b.model = truth.model;
  const CoefficientIndex x = coefficient_index("gyro.offset.x");
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
    const CoefficientIndex at = a.estimated[static_cast<std::size_t>(i)];
    set_coefficient(b.model, at, coefficient_value(a.model, at) + e(i));
  }
  const Consistency c = compare(a, b).consistency;
  const double expected = e.dot((a.covariance + b.covariance).ldlt().solve(e));
  EXPECT_EQ(c.degrees_of_freedom, 30);
  EXPECT_NEAR(c.chi2, expected, 1e-6 * expected);  // e is a difference of values 1e5 times larger; the condition costs two more digits
  EXPECT_NEAR(c.p_value, chi_square_tail(expected, 30), 1e-5);
}

TEST(Compare, TestsOnlyWhatBothEstimated) {
  Calibration a = any_calibration(3), b;
  b.model = a.model;
  b.estimated = coefficients({"gyro.offset", "accel.thermal"});
  b.covariance = 1e-12 * Eigen::MatrixXd::Identity(12, 12);
  const Comparison comparison = compare(a, b);
  EXPECT_EQ(comparison.consistency.degrees_of_freedom, 3);
  EXPECT_EQ(comparison.coefficients.size(), 30u + 9);
}

/// Returns the calibration in a rig's frame: a' = F a with a fixed F.
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
  out.frame = BodyFrame::rig;
  out.model = turned(c.model);
  out.estimated.clear();
  for (const char* s : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const CoefficientIndex i : select_coefficients(s)) out.estimated.push_back(i);
  Eigen::MatrixXd jacobian(out.estimated.size(), c.estimated.size());  // the map is linear: its columns are images of unit vectors
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    SensorModel unit;
    for (const CoefficientIndex i : coefficient_indices()) set_coefficient(unit, i, 0);
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
    const CoefficientIndex at = b.estimated[k];
    const auto i = static_cast<Eigen::Index>(k);
    set_coefficient(b.model, at, coefficient_value(b.model, at) + std::sqrt(b.covariance(i, i)) * draws(1, 30, 6)(i));
  }
  const Comparison here = compare(a, b);
  const Comparison there = compare(in_frame(a, rotation_exp({0.5, -0.3, 1.2})), in_frame(b, rotation_exp({-2, 0.1, 0.4})));
  ASSERT_EQ(here.coefficients.size(), 30u);
  for (const auto& d : here.coefficients) {
    const auto name = coefficient(d.index).name;
    // Differences are 1e-5 of the values, and even smaller relative to the rotated vector: five to six of sixteen digits are lost.
    EXPECT_NEAR(*find(there, name).sigmas(), *d.sigmas(), 1e-5 * (1 + std::abs(*d.sigmas()))) << name;
    EXPECT_NEAR(*find(there, name).user_sigmas(), *d.user_sigmas(), 1e-5 * (1 + std::abs(*d.user_sigmas()))) << name;
  }
  EXPECT_EQ(there.consistency.degrees_of_freedom, 30);
  EXPECT_NEAR(there.consistency.chi2, here.consistency.chi2, 1e-4 * here.consistency.chi2);
}

TEST(Compare, ErrorsDrawnFromTheStatedCovarianceAreConsistent) {
  const Calibration truth = [] {
    Calibration t;
    t.model = model_of_counts();
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

TEST(Compare, SeveralHaveTheSameRowsInTheSameUnits) {
  const Calibration a = any_calibration(3);
  Calibration b = a, c = a;
  b.model.accel.offset.x() += 30 * unit::ug;
  c.model.accel.offset.y() += 50e3 * unit::ug;
  c.model.lever_arm(0, 1) += 0.004;
  const std::vector<Comparison> both = compare(a, std::vector{b, c});
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].coefficients.size(), 31u);
  ASSERT_EQ(both[0].coefficients.size(), both[1].coefficients.size());
  for (std::size_t i = 0; i < both[0].coefficients.size(); ++i) {
    const CoefficientDifference &x = both[0].coefficients[i], &y = both[1].coefficients[i];
    EXPECT_EQ(std::tie(x.index, x.user_unit), std::tie(y.index, y.user_unit));
  }
  EXPECT_NEAR(find(both[0], "accel.offset.x").user_difference, 0.03, 1e-12);  // mg, because of c: 0.1 m/s^2 has a rounding of 1e-17, 1e-15 mg
  EXPECT_NEAR(find(both[1], "accel.offset.y").user_difference, 50, 1e-9);
  EXPECT_EQ(find(both[0], "accel.lever_arm.xy").difference, 0);
  for (const auto& [pair, several] : {std::pair(compare(a, b), both[0]), std::pair(compare(a, c), both[1])}) {
    EXPECT_EQ(pair.consistency.chi2, several.consistency.chi2);
    for (const auto& d : pair.coefficients) EXPECT_EQ(d.difference, find(several, coefficient(d.index).name).difference);
  }
}

/// Zhang 2010, table 2: one ring laser IMU calibrated three times, the last time on a table with errors of arc minutes, in the frame of the table.
TEST(Compare, ZhangsCalibrationsDifferAsHisTable3Says) {
  const auto zhang = [](const Vector3d& gyro_offset_deg_per_h, const Vector3d& accel_offset, const Matrix3d& gyro, const Matrix3d& accel) {
    Calibration c;
    c.frame = BodyFrame::rig;
    c.model.gyro.offset = unit::deg_per_h * gyro_offset_deg_per_h;
    c.model.accel.offset = accel_offset;
    c.model.gyro.matrix = gyro;
    c.model.accel.matrix = accel;
    return c;
  };
  Matrix3d gyro1, gyro2, gyro3, accel1, accel2, accel3;
  gyro1 << 1.3794e-8, 7.14e-12, -3.13e-11, -6.90e-12, 1.3787e-8, -1.54e-11, 1.33e-12, 1.97e-14, 1.3791e-8;
  gyro2 << 1.3794e-8, 7.19e-12, -3.13e-11, -6.87e-12, 1.3787e-8, -1.54e-11, 1.33e-12, -6.00e-15, 1.3791e-8;
  gyro3 << 1.3796e-8, 9.06e-12, -3.13e-11, -7.61e-12, 1.3788e-8, -1.94e-11, -2.04e-12, -3.11e-12, 1.3796e-8;
  accel1 << 1.7589e-6, 4.90e-10, 1.22e-9, -3.48e-9, 1.7163e-6, 2.97e-9, -2.05e-9, 1.34e-9, 1.7516e-6;
  accel2 << 1.7589e-6, 4.82e-10, 1.22e-9, -3.50e-9, 1.7163e-6, 2.97e-9, -2.05e-9, 1.34e-9, 1.7515e-6;
  accel3 << 1.7586e-6, 6.34e-10, 1.20e-9, -3.52e-9, 1.7163e-6, 3.32e-9, -1.84e-9, 1.14e-9, 1.7513e-6;
  const Calibration first = zhang({0.1114, 0.0455, -0.2141}, {-5.53e-3, 7.72e-3, -7.12e-3}, gyro1, accel1);
  const Calibration second = zhang({0.1167, 0.0387, -0.2128}, {-5.54e-3, 7.73e-3, -7.01e-3}, gyro2, accel2);
  const Calibration third = zhang({0.0993, 0.0402, -0.2098}, {-5.73e-3, 8.31e-3, -7.42e-3}, gyro3, accel3);
  const std::vector<Comparison> table = compare(first, std::vector{second, third});
  const double gyro_differences[2][3] = {{0.0053, -0.0068, 0.0013}, {-0.0120, -0.0053, 0.0043}};
  const double accel_differences[2][3] = {{-1.74e-5, 1.18e-5, 1.04e-4}, {-2.06e-4, 5.92e-4, -2.98e-4}};
  const double scale_differences[2][3] = {{3.53e-15, 1.31e-15, 2.93e-16}, {1.79e-12, 1.82e-12, 5.64e-12}};
  for (const std::size_t k : {0u, 1u})
    for (const int axis : {0, 1, 2}) {
      const std::string letter(1, "xyz"[axis]);
      // The tolerance is half a last digit of each of the three numbers. The accelerometer frames differ by 2e-4 rad, which is 2e-6 m/s^2 and 4e-5
      // deg/h of the offsets, and by 3e-3 rad from the table's: as much again of their differences.
      EXPECT_NEAR(find(table[k], "gyro.offset." + letter).difference / unit::deg_per_h, gyro_differences[k][axis], 1.5e-4 + 8e-5);
      EXPECT_NEAR(find(table[k], "accel.offset." + letter).difference, accel_differences[k][axis], 1.05e-5 + 4e-6);
      EXPECT_NEAR(find(table[k], "gyro.matrix." + letter + letter).difference, scale_differences[k][axis], 1.05e-12);
    }
}

TEST(Compare, ASingularMatrixIsAnError) {
  Calibration a = any_calibration(3);
  a.model.gyro.matrix.setZero();
  EXPECT_THROW(compare(a, any_calibration(3)), Error);
}

// The same IMU at another place on its table has other lever arms but does not differ; an accelerometer that moved relative to the others does.
TEST(Compare, AMountElsewhereIsNoDifference) {
  Calibration a;
  a.model = model_of_counts();
  a.estimated = coefficients({"accel.lever_arm"});
  a.covariance = 1e-8 * Eigen::MatrixXd::Identity(9, 9);
  Calibration b = a;
  const Vector3d moved(0.05, -0.02, 0.03);
  b.model.lever_arm.rowwise() += moved.transpose();
  const Comparison same = compare(a, b);
  ASSERT_TRUE(same.translation.has_value());
  EXPECT_LT((*same.translation - moved).norm(), 1e-12);
  EXPECT_LT(same.consistency.chi2, 1e-12);
  EXPECT_EQ(same.consistency.degrees_of_freedom, 6);
  EXPECT_LT(agreement({a, b}).consistency.chi2, 1e-12);

  b.model.lever_arm(0, 0) += 3e-3;
  // Relative to the mean point, 3 mm become 2 mm and twice -1 mm, with an uncertainty of 0.1 mm each.
  EXPECT_NEAR(compare(a, b).consistency.chi2, (2 * 2 + 1 + 1) * 1e-6 / 2e-8, 1e-6);
  EXPECT_NEAR(agreement({a, b}).consistency.chi2, 300, 1e-6);
}

}  // namespace
}  // namespace imulab
