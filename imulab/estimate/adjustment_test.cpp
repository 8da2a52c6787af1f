#include "imulab/estimate/adjustment.hpp"

#include "imulab/core/random.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Random conditions of `blocks` blocks of three rows whose neighbours are correlated, and their covariance in full.
struct Example {
  Conditions conditions;
  MatrixXd covariance;
};

Example example(int blocks, Index unknowns, std::uint64_t seed) {
  const RandomStream draws(seed, "adjustment example");
  std::uint64_t next = 0;
  const auto random = [&](Index r, Index c) { return MatrixXd::NullaryExpr(r, c, [&] { return draws.normal(next++); }); };
  const Index rows = 3 * blocks;
  Example e;
  MatrixXd lower = MatrixXd::Zero(rows, rows);  // a banded factor gives a block-tridiagonal covariance
  for (Index k = 0; k < blocks; ++k) {
    lower.block(3 * k, 3 * k, 3, 3) = 2 * MatrixXd::Identity(3, 3) + 0.3 * random(3, 3);
    if (k > 0) lower.block(3 * k, 3 * (k - 1), 3, 3) = 0.4 * random(3, 3);
  }
  e.covariance = lower * lower.transpose();
  Conditions& c = e.conditions;
  c.jacobian = random(rows, unknowns);
  c.value = lower * random(rows, 1);
  c.variance = e.covariance.diagonal();
  c.spread_gain = VectorXd::Ones(rows);
  c.kind.assign(static_cast<std::size_t>(rows), ConditionKind::gravity);
  for (Index k = 0; k < blocks; ++k)
    c.blocks.push_back({3 * k, 3, e.covariance.block(3 * k, 3 * k, 3, 3), k > 0 ? MatrixXd(e.covariance.block(3 * k, 3 * (k - 1), 3, 3)) : MatrixXd()});
  return e;
}

TEST(Adjustment, EqualsGeneralizedLeastSquares) {
  const Example e = example(8, 4, 3);
  const Conditions& c = e.conditions;
  const Adjustment a = adjust(c, VectorXd::Constant(4, 100.0));
  const MatrixXd weight = e.covariance.inverse();
  const MatrixXd p = (c.jacobian.transpose() * weight * c.jacobian).inverse();
  const VectorXd x = -p * c.jacobian.transpose() * weight * c.value;
  const VectorXd r = c.value + c.jacobian * x;
  // Both are exact: rounding of matrices of condition below 1e4.
  EXPECT_LT((a.correction - x).norm(), 1e-11 * x.norm());
  EXPECT_LT((a.covariance - p).norm(), 1e-11 * p.norm());
  EXPECT_NEAR(a.chi2, r.dot(weight * r), 1e-10 * a.chi2);
  EXPECT_EQ(a.degrees_of_freedom, 20);
  EXPECT_LT((a.residual_variance - (e.covariance - c.jacobian * p * c.jacobian.transpose()).diagonal()).norm(), 1e-10);
}

TEST(Adjustment, NamesWhatTheDataLeaveOpenAndCountsItsPrior) {
  Example e = example(8, 4, 5);
  Conditions& c = e.conditions;
  c.jacobian.col(3).setZero();
  const Adjustment a = adjust(c, VectorXd::Constant(4, 100.0));
  EXPECT_EQ(a.determined, (std::vector<char>{1, 1, 1, 0}));
  EXPECT_EQ(a.correction[3], 0);

  // A column known only through a weak row: the others' uncertainty grows as if it had its prior sigma, 0.1.
  c.jacobian.col(3) = 1e-3 * e.conditions.jacobian.col(0) + 1e-3 * VectorXd::Ones(c.value.size());
  VectorXd sigma(4);
  sigma << 100, 100, 100, 0.1;
  const Adjustment b = adjust(c, sigma);
  ASSERT_EQ(b.determined[3], 0);
  const MatrixXd weight = e.covariance.inverse();
  const MatrixXd known = c.jacobian.leftCols(3);
  const MatrixXd p = (known.transpose() * weight * known).inverse();
  const VectorXd leak = p * known.transpose() * weight * c.jacobian.col(3);
  const MatrixXd expected = p + 0.01 * leak * leak.transpose();
  EXPECT_LT((b.covariance.topLeftCorner(3, 3) - expected).norm(), 1e-11 * expected.norm());
}

TEST(Adjustment, OutlierStatisticIsTheDropOfChiSquareWithoutTheRows) {
  Example e = example(10, 4, 7);
  Conditions& with = e.conditions;
  with.blocks.back().coupling = MatrixXd();  // so that the rest keeps its covariance without the last block
  Conditions without = with;
  without.blocks.pop_back();
  const Index rows = 27;
  without.value.conservativeResize(rows);
  without.jacobian.conservativeResize(rows, 4);
  without.variance.conservativeResize(rows);
  without.spread_gain.conservativeResize(rows);
  without.kind.resize(static_cast<std::size_t>(rows));
  const VectorXd prior = VectorXd::Constant(4, 100.0);
  for (const double shift : {0.0, 1000.0}) {  // once within double's range and once beyond it
    with.value[28] += shift;
    const Adjustment all = adjust(with, prior);
    const double drop = all.chi2 - adjust(without, prior).chi2;
    // chi-square with 3 degrees of freedom: P(X > x) = erfc(sqrt(x/2)) + sqrt(2x/pi) exp(-x/2); the second term alone far out
    const double log_tail = shift == 0 ? std::log(std::erfc(std::sqrt(drop / 2)) + std::sqrt(2 * drop / M_PI) * std::exp(-drop / 2))
                                       : 0.5 * std::log(2 * drop / M_PI) - drop / 2;
    EXPECT_NEAR(outlier_log_probability(with, all, {27, 28, 29}), log_tail, 1e-9 * std::abs(log_tail) + 1e-9);
  }
  EXPECT_EQ(outlier_log_probability(with, adjust(with, prior), {}), 0) << "nothing is not suspicious";
}

TEST(Adjustment, OutlierProbabilityIsTheChiSquareTail) {
  // One unknown-free example: two rows of variance 4, residuals 2 and 4 sigmas: chi-square 20 with two degrees of freedom, p = exp(-10).
  Conditions c;
  c.value = Eigen::Vector2d(4, 8);
  c.jacobian = MatrixXd::Zero(2, 1);
  c.variance = VectorXd::Constant(2, 4.0);
  c.spread_gain = VectorXd::Ones(2);
  c.kind.assign(2, ConditionKind::rotation);
  c.blocks = {{0, 2, 4 * MatrixXd::Identity(2, 2), {}}};
  EXPECT_NEAR(outlier_log_probability(c, adjust(c, VectorXd::Ones(1)), {0, 1}), -10, 1e-9);
}

TEST(Adjustment, SpreadIsFoundWhereThereIsAndOnlyThere) {
  // 600 independent rows of unit noise and a spread of 2: variance 5. The estimate of the variance 5 has a relative sigma of sqrt(2/600) = 5.8 %.
  const int rows = 600;
  const auto with_spread = [&](double spread) {
    const RandomStream noise(11, "noise"), extra(11, "extra");
    Conditions c;
    c.value.resize(rows);
    c.jacobian = MatrixXd::Zero(rows, 2);
    for (Index i = 0; i < rows; ++i) {
      c.value[i] = noise.normal(static_cast<std::uint64_t>(i)) + spread * extra.normal(static_cast<std::uint64_t>(i));
      c.jacobian(i, 0) = 1;
      c.jacobian(i, 1) = std::sin(0.1 * static_cast<double>(i));
      c.blocks.push_back({i, 1, MatrixXd::Ones(1, 1), {}});
    }
    c.variance = c.spread_gain = VectorXd::Ones(rows);
    c.kind.assign(rows, ConditionKind::rotation);
    return c;
  };
  const Conditions quiet = with_spread(0), loud = with_spread(2);
  const VectorXd prior = VectorXd::Constant(2, 100.0);
  EXPECT_EQ(estimate_spread(quiet, adjust(quiet, prior), ConditionKind::rotation, 0), 0);
  const double found = estimate_spread(loud, adjust(loud, prior), ConditionKind::rotation, 0);
  EXPECT_NEAR(1 + found * found, 5, 3.3 * 0.058 * 5);  // 99.9 %
  EXPECT_EQ(estimate_spread(loud, adjust(loud, prior), ConditionKind::gravity, 0), 0);
}

}  // namespace
}  // namespace imulab
