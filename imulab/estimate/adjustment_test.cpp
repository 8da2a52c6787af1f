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

/// Random conditions of `blocks` blocks of three rows whose neighbours are correlated, then a prior row for each parameter; and their covariance in full.
struct Example {
  Conditions conditions;
  MatrixXd covariance;
};

Example example(int blocks, const VectorXd& prior_sigma, std::uint64_t seed) {
  const RandomStream draws(seed, "adjustment example");
  std::uint64_t next = 0;
  const auto random = [&](Index r, Index c) { return MatrixXd::NullaryExpr(r, c, [&] { return draws.normal(next++); }); };
  const Index rows = 3 * blocks, unknowns = prior_sigma.size();
  MatrixXd lower = MatrixXd::Zero(rows, rows);  // a banded factor gives a block-tridiagonal covariance
  for (Index k = 0; k < blocks; ++k) {
    lower.block(3 * k, 3 * k, 3, 3) = 2 * MatrixXd::Identity(3, 3) + 0.3 * random(3, 3);
    if (k > 0) lower.block(3 * k, 3 * (k - 1), 3, 3) = 0.4 * random(3, 3);
  }
  Example e;
  e.covariance = MatrixXd::Zero(rows + unknowns, rows + unknowns);
  e.covariance.topLeftCorner(rows, rows) = lower * lower.transpose();
  e.covariance.bottomRightCorner(unknowns, unknowns) = prior_sigma.cwiseAbs2().asDiagonal();
  Conditions& c = e.conditions;
  c.jacobian.resize(rows + unknowns, unknowns);
  c.jacobian << random(rows, unknowns), MatrixXd::Identity(unknowns, unknowns);
  c.value.resize(rows + unknowns);
  c.value << lower * random(rows, 1), VectorXd::Zero(unknowns);
  c.variance = e.covariance.diagonal();
  c.spread_gain = VectorXd::Ones(rows + unknowns);
  c.kind.assign(static_cast<std::size_t>(rows + unknowns), ConditionKind::gravity);
  for (Index k = 0; k < blocks; ++k)
    c.blocks.push_back({3 * k, 3, e.covariance.block(3 * k, 3 * k, 3, 3), k > 0 ? MatrixXd(e.covariance.block(3 * k, 3 * (k - 1), 3, 3)) : MatrixXd()});
  for (Index u = 0; u < unknowns; ++u) {
    c.kind[static_cast<std::size_t>(rows + u)] = ConditionKind::prior;
    c.blocks.push_back({rows + u, 1, MatrixXd::Constant(1, 1, prior_sigma[u] * prior_sigma[u]), {}});
  }
  return e;
}

TEST(Adjustment, EqualsGeneralizedLeastSquares) {
  const VectorXd prior = VectorXd::Constant(4, 100.0);
  const Example e = example(8, prior, 3);
  const Conditions& c = e.conditions;
  const Adjustment a = adjust(c, prior);
  const MatrixXd weight = e.covariance.inverse();
  const MatrixXd p = (c.jacobian.transpose() * weight * c.jacobian).inverse();
  const VectorXd x = -p * c.jacobian.transpose() * weight * c.value;
  const VectorXd r = (c.value + c.jacobian * x).head(24);
  // Both are exact: rounding of matrices of condition below 1e4.
  EXPECT_LT((a.correction - x).norm(), 1e-10 * x.norm());
  EXPECT_LT((a.covariance - p).norm(), 1e-10 * p.norm());
  EXPECT_NEAR(a.chi2, r.dot(weight.topLeftCorner(24, 24) * r), 1e-9 * a.chi2);
  EXPECT_NEAR(a.degrees_of_freedom, 20, 1e-4) << "24 rows and 4 parameters whose priors say next to nothing";
  // A row that the fit follows has a residual variance of rounding; none is that near here.
  EXPECT_LT((a.residual_variance - (e.covariance - c.jacobian * p * c.jacobian.transpose()).diagonal()).head(24).norm(), 1e-9);
}

TEST(Adjustment, NamesWhatTheDataLeaveOpenAndCountsItsPrior) {
  VectorXd prior(4);
  prior << 100, 100, 100, 0.1;
  Example e = example(8, prior, 5);
  Conditions& c = e.conditions;
  c.jacobian.col(3).head(24) *= 1e-3;  // known only through weak rows
  const Adjustment a = adjust(c, prior);
  EXPECT_EQ(a.determined, (std::vector<char>{1, 1, 1, 0}));
  // The others' covariance is that of data whose noise has the undetermined parameter's in it.
  const MatrixXd known = c.jacobian.topLeftCorner(24, 3);
  const MatrixXd noise = e.covariance.topLeftCorner(24, 24) + 0.01 * c.jacobian.col(3).head(24) * c.jacobian.col(3).head(24).transpose();
  const MatrixXd p = (known.transpose() * noise.inverse() * known + 1e-4 * MatrixXd::Identity(3, 3)).inverse();
  EXPECT_LT((a.covariance.topLeftCorner(3, 3) - p).norm(), 1e-10 * p.norm());
  EXPECT_GE(a.residual_variance.head(24).minCoeff(), 0.01 * c.variance.head(24).minCoeff()) << "what is not known cannot make residuals smaller";
}

TEST(Adjustment, DeviationIsTheChiSquareSavedByLeavingRowsOut) {
  const VectorXd prior = VectorXd::Constant(4, 100.0);
  Example e = example(10, prior, 7);
  Conditions& with = e.conditions;
  with.blocks[9].coupling = MatrixXd();  // so that the rest keeps its covariance without this block
  Conditions without = with;
  without.blocks[9].covariance *= 1e12;
  const auto total = [](const Adjustment& a) { return a.chi2 + a.correction.squaredNorm() / 1e4; };  // with the priors' part
  for (const double shift : {0.0, 1000.0}) {  // once within double's range and once beyond it
    with.value[28] += shift;
    without.value[28] += shift;
    const Adjustment all = adjust(with, prior);
    const double saved = total(all) - total(adjust(without, prior));
    const Deviation deviation = deviation_of(with, all, {27, 28, 29});
    EXPECT_EQ(deviation.degrees_of_freedom, 3);
    EXPECT_NEAR(deviation.statistic, saved, 1e-6 * saved);  // the weight of 1e-12 that remains
    // chi-square with 3 degrees of freedom: P(X > x) = erfc(sqrt(x/2)) + sqrt(2x/pi) exp(-x/2); the second term alone far out
    const double x = deviation.statistic;
    const double log_tail = shift == 0 ? std::log(std::erfc(std::sqrt(x / 2)) + std::sqrt(2 * x / M_PI) * std::exp(-x / 2)) : 0.5 * std::log(2 * x / M_PI) - x / 2;
    EXPECT_NEAR(deviation.log_probability(), log_tail, 1e-9 * std::abs(log_tail) + 1e-9);
  }
  EXPECT_EQ(deviation_of(with, adjust(with, prior), {}).log_probability(), 0) << "nothing is not suspicious";
}

TEST(Adjustment, ASpreadFromFewResidualsMakesOutliersLessSure) {
  const Deviation deviation{20, 2};
  EXPECT_NEAR(deviation.log_probability(), -10, 1e-12);  // exp(-x/2)
  // F with (2, d) degrees of freedom: P(F > f) = (1 + 2 f / d)^(-d/2)
  EXPECT_NEAR(deviation.log_probability(10), -5 * std::log(1 + 2.0 * 10 / 10), 1e-9);
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
  EXPECT_FALSE(spread_is_significant(quiet, adjust(quiet, prior), ConditionKind::rotation));
  EXPECT_TRUE(spread_is_significant(loud, adjust(loud, prior), ConditionKind::rotation));
  EXPECT_FALSE(spread_is_significant(loud, adjust(loud, prior), ConditionKind::gravity)) << "no such rows";
  const double found = estimate_spread(loud, adjust(loud, prior), ConditionKind::rotation, 0);
  EXPECT_NEAR(1 + found * found, 5, 3.3 * 0.058 * 5);  // 99.9 %
  EXPECT_NEAR(redundancy(loud, adjust(loud, prior), ConditionKind::rotation), rows - 2, 1e-6);
}

}  // namespace
}  // namespace imulab
