// Several calibrations with one true model.
#include "imulab/coefficient.hpp"
#include "imulab/compare.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

Eigen::MatrixXd drawn_coefficients(Eigen::Index rows, Eigen::Index columns, std::uint64_t stream) {
  const RandomStream random(20261122, stream);
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = random.normal(static_cast<std::uint64_t>(i));
  return m;
}

/// Returns an estimate of an IMU with unit matrices and zero other coefficients. Its error is drawn from its stated covariance, which correlates all
/// coefficients. The stream determines the covariance, the draw the error.
Calibration drawn(const std::vector<const char*>& terms, double sigma, std::uint64_t stream, std::uint64_t draw) {
  Calibration c;
  for (const char* term : terms)
    for (const CoefficientIndex i : select_coefficients(term)) {
      const Coefficient& x = coefficient(i);
      if (x.triad != Triad::accel || x.term != Term::matrix || x.column <= x.row) c.estimated.push_back(i);
    }
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  const Eigen::MatrixXd l = sigma * (Eigen::MatrixXd::Identity(n, n) + 0.3 / std::sqrt(static_cast<double>(n)) * drawn_coefficients(n, n, stream));
  c.covariance = l * l.transpose();
  const Eigen::VectorXd e = l * drawn_coefficients(n, 1, draw);
  for (Eigen::Index k = 0; k < n; ++k) {
    const CoefficientIndex i = c.estimated[static_cast<std::size_t>(k)];
    set_coefficient(c.model, i, coefficient_value(c.model, i) + e(k));
  }
  return c;
}

const std::vector<const char*> linear{"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"};  // 21: 3 + 6 + 3 + 9

const Agreement::Coefficient& found_in(const Agreement& agreement, const char* name) {
  for (const auto& c : agreement.coefficients)
    if (c.index == coefficient_index(name)) return c;
  throw std::runtime_error(name);
}

TEST(Agreement, OfOneCoefficientIsTheWeightedSumOfSquares) {
  const std::array<double, 3> value{1e-3, 4e-3, -2e-3}, sigma{1e-3, 2e-3, 0.5e-3};
  std::vector<Calibration> calibrations;
  double weights = 0, mean = 0, expected = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    Calibration c;
    c.estimated = {coefficient_index("gyro.offset.y")};
    c.covariance = Eigen::MatrixXd::Constant(1, 1, sigma[k] * sigma[k]);
    c.model.gyro.offset.y() = value[k];
    calibrations.push_back(c);
    weights += std::pow(sigma[k], -2);
    mean += value[k] * std::pow(sigma[k], -2);
  }
  for (std::size_t k = 0; k < 3; ++k) expected += std::pow((value[k] - mean / weights) / sigma[k], 2);
  const Agreement joint = agreement(calibrations);
  EXPECT_EQ(joint.calibrations, 3);
  ASSERT_EQ(joint.coefficients.size(), 1u);
  for (const Consistency& c : {joint.consistency, joint.coefficients[0].consistency}) {
    EXPECT_EQ(c.degrees_of_freedom, 2);
    EXPECT_NEAR(c.chi2, expected, 1e-12 * expected);         // rounding
    EXPECT_NEAR(c.p_value, std::exp(-expected / 2), 1e-12);  // the tail for two degrees of freedom
  }
}

TEST(Agreement, OfTwoIsTheirComparison) {
  const Calibration a = drawn(linear, 1e-5, 1, 11), b = drawn({"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}, 3e-5, 2, 12);
  const Comparison pair = compare(a, b);
  const Agreement joint = agreement({a, b});
  EXPECT_EQ(joint.consistency.degrees_of_freedom, 12);
  EXPECT_EQ(joint.consistency.degrees_of_freedom, pair.consistency.degrees_of_freedom);
  EXPECT_NEAR(joint.consistency.chi2, pair.consistency.chi2, 1e-9 * pair.consistency.chi2);  // values of one contain differences of 1e-5 to 1e-11
  ASSERT_EQ(joint.coefficients.size(), 12u);
  for (const auto& c : joint.coefficients) {
    const auto d = std::find_if(pair.coefficients.begin(), pair.coefficients.end(), [&](const auto& x) { return x.index == c.index; });
    ASSERT_NE(d, pair.coefficients.end());
    EXPECT_NEAR(std::sqrt(c.consistency.chi2), std::abs(*d->user_sigmas()), 1e-9) << c.index;
  }
}

/// Returns min over x of sum (x_k - H_k x)^T P_k^-1 (x_k - H_k x), by QR of the whitened observations.
double least_squares(const std::vector<Calibration>& calibrations) {
  Eigen::Index rows = 0;
  for (const auto& c : calibrations) rows += c.covariance.rows();
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(rows, coefficient_count);
  Eigen::VectorXd observed(rows);
  Eigen::Index at = 0;
  for (const auto& c : calibrations) {
    const Eigen::Index n = c.covariance.rows();
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, coefficient_count);
    Eigen::VectorXd x(n);
    const SensorModel nominal;
    for (Eigen::Index k = 0; k < n; ++k) {
      const CoefficientIndex i = c.estimated[static_cast<std::size_t>(k)];
      h(k, i) = 1;
      x(k) = coefficient_value(c.model, i) - coefficient_value(nominal, i);
    }
    const Eigen::LLT<Eigen::MatrixXd> p(c.covariance);
    design.middleRows(at, n) = p.matrixL().solve(h);
    observed.segment(at, n) = p.matrixL().solve(x);
    at += n;
  }
  const Eigen::VectorXd x = design.completeOrthogonalDecomposition().solve(observed);
  return (observed - design * x).squaredNorm();
}

TEST(Agreement, IsTheSumOfSquaresAboutTheWeightedMean) {
  const std::vector<const char*> offsets{"accel.offset", "gyro.offset"};
  for (const double poor : {1e-5, 10.0}) {  // as accurate as the others, and a million times less accurate
    std::vector<Calibration> calibrations{drawn(offsets, poor, 1, 21), drawn(linear, 1e-5, 2, 22), drawn(linear, 2e-5, 3, 23),
                                          drawn({"gyro.offset", "gyro.g_sensitivity", "accel.offset"}, 1e-6, 4, 24)};
    const Agreement joint = agreement(calibrations);
    EXPECT_EQ(joint.calibrations, 4);
    EXPECT_EQ(joint.consistency.degrees_of_freedom, 3 * 6 + 15) << "what one alone estimated, the g-sensitivity, is no test";
    const double expected = least_squares(calibrations);
    EXPECT_NEAR(joint.consistency.chi2, expected, 1e-8 * expected);  // values of one contain errors of 1e-5 to 1e-11; whitening costs two digits
    std::swap(calibrations[0], calibrations[3]);
    EXPECT_NEAR(agreement(calibrations).consistency.chi2, expected, 1e-8 * expected) << "whichever is the first";
  }
}

/// Expects uniform p-values of consistent calibrations: of 500 draws, 50 are in each tenth, and the chi-square of the counts has nine degrees of
/// freedom. Uses its 99.9 % band; below 0.05 %, the counts would be too even.
void expect_uniform(const std::vector<double>& p_values, const char* what) {
  std::array<int, 10> counts{};
  for (const double p : p_values) ++counts[std::min<std::size_t>(9, static_cast<std::size_t>(10 * p))];
  const double expected = static_cast<double>(p_values.size()) / 10;
  double chi2 = 0;
  for (const int n : counts) chi2 += (n - expected) * (n - expected) / expected;
  EXPECT_GT(chi2, chi_square_quantile(0.0005, 9)) << what;
  EXPECT_LT(chi2, chi_square_quantile(0.9995, 9)) << what;
}

TEST(Agreement, OfCalibrationsDrawnFromTheirCovariancesIsUniform) {
  std::vector<double> together, scale, offset;
  int differing = 0;
  constexpr int runs = 500;
  for (std::uint64_t run = 0; run < runs; ++run) {
    std::vector<Calibration> calibrations;
    for (std::uint64_t k = 0; k < 3; ++k)
      calibrations.push_back(drawn(linear, std::pow(3.0, static_cast<double>(k)) * 1e-6, 1 + k, 1000 + 3 * run + k));
    const Agreement joint = agreement(calibrations);
    ASSERT_EQ(joint.consistency.degrees_of_freedom, 2 * 21);
    together.push_back(joint.consistency.p_value);
    scale.push_back(found_in(joint, "gyro.matrix.zz").consistency.p_value);
    offset.push_back(found_in(joint, "accel.offset.x").consistency.p_value);
    differing += std::any_of(joint.coefficients.begin(), joint.coefficients.end(), [](const auto& c) { return c.differs; });
  }
  expect_uniform(together, "together");
  expect_uniform(scale, "gyro.matrix.zz");
  expect_uniform(offset, "accel.offset.x");
  // At most one table in a hundred names a coefficient: Bonferroni's bound is 1 % for any correlations.
  EXPECT_LE(differing, binomial_quantile(0.9995, runs, table_significance));
}

TEST(Agreement, NamesWhatDiffers) {
  std::vector<Calibration> calibrations{drawn(linear, 1e-5, 1, 31), drawn(linear, 1e-5, 2, 32), drawn(linear, 1e-5, 3, 33)};
  const Agreement before = agreement(calibrations);
  calibrations[2].model.gyro.offset.z() += 20e-5;  // 20 sigma of its own, 16 relative to the mean of three
  const Agreement after = agreement(calibrations);
  EXPECT_LT(after.consistency.p_value, 1e-6);
  ASSERT_EQ(after.coefficients.size(), 21u);
  for (std::size_t i = 0; i < 21; ++i) {
    const Agreement::Coefficient &x = before.coefficients[i], &y = after.coefficients[i];
    if (y.index == coefficient_index("gyro.offset.z")) {
      EXPECT_TRUE(y.differs);
    } else {
      EXPECT_EQ(y.differs, x.differs) << y.index;  // one draw in a hundred names another by chance, as before
      EXPECT_EQ(y.consistency.chi2, x.consistency.chi2) << y.index;
    }
  }
}

TEST(Agreement, ATruthTakesNoPart) {
  Calibration truth;
  truth.model.gyro.offset.x() = 1;
  const std::vector<Calibration> with{truth, drawn(linear, 1e-5, 1, 41), drawn(linear, 1e-5, 2, 42), drawn(linear, 1e-5, 3, 43)};
  const Agreement a = agreement(with), b = agreement({with[1], with[2], with[3]});
  EXPECT_EQ(a.calibrations, 3);
  EXPECT_EQ(a.consistency.chi2, b.consistency.chi2);
  EXPECT_EQ(agreement({truth, truth}).calibrations, 0);
  EXPECT_EQ(agreement({truth, truth}).consistency.degrees_of_freedom, 0);
  EXPECT_EQ(agreement({}).calibrations, 0);
}

}  // namespace
}  // namespace imulab
