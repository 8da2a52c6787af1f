#include "imulab/estimate/rests/conditions.hpp"

#include "imulab/core/random.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace imulab::rests {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Random conditions with `blocks` blocks of three rows, correlated neighbors, and the full covariance.
struct Example {
  Conditions conditions;
  MatrixXd covariance;
};

constexpr Index unknowns = 4;
constexpr double endless = std::numeric_limits<double>::infinity();

Example example(int blocks, std::uint64_t seed) {
  const RandomStream draws(seed, "adjustment example");
  std::uint64_t next = 0;
  const auto random = [&](Index r, Index c) { return MatrixXd::NullaryExpr(r, c, [&] { return draws.normal(next++); }); };
  const Index rows = 3 * blocks;
  MatrixXd lower = MatrixXd::Zero(rows, rows);  // a banded factor gives a block tridiagonal covariance
  for (Index k = 0; k < blocks; ++k) {
    lower.block(3 * k, 3 * k, 3, 3) = 2 * MatrixXd::Identity(3, 3) + 0.3 * random(3, 3);
    if (k > 0) lower.block(3 * k, 3 * (k - 1), 3, 3) = 0.4 * random(3, 3);
  }
  Example e{Conditions(rows, unknowns), lower * lower.transpose()};
  e.conditions.jacobian = random(rows, unknowns);
  e.conditions.value = lower * random(rows, 1);
  for (Index k = 0; k < blocks; ++k)
    e.conditions.blocks.push_back(
        {3 * k, 3, e.covariance.block(3 * k, 3 * k, 3, 3), k > 0 ? MatrixXd(e.covariance.block(3 * k, 3 * (k - 1), 3, 3)) : MatrixXd()});
  return e;
}

/// Returns four unknowns with an almost uninformative prior of 100.
kernel::Parameters loose() {
  kernel::Parameters parameters(unknowns);
  parameters.sigma.setConstant(100);
  return parameters;
}

TEST(Adjustment, EqualsGeneralizedLeastSquares) {
  const Example e = example(8, 3);
  const Conditions& c = e.conditions;
  const Adjustment a = adjust(c, loose());
  const MatrixXd weight = e.covariance.inverse();
  const MatrixXd p = (c.jacobian.transpose() * weight * c.jacobian + 1e-4 * MatrixXd::Identity(4, 4)).inverse();
  const VectorXd x = -p * c.jacobian.transpose() * weight * c.value, r = c.value + c.jacobian * x;
  // Both are exact except for rounding of matrices with a condition number below 1e4.
  EXPECT_LT((a.solution.x - x).norm(), 1e-10 * x.norm());
  EXPECT_LT((a.solution.covariance - p).norm(), 1e-10 * p.norm());
  EXPECT_NEAR(a.solution.chi2, r.dot(weight * r), 1e-9 * a.solution.chi2);
  EXPECT_NEAR(a.solution.degrees_of_freedom, 20, 1e-4) << "24 rows and 4 parameters whose priors say next to nothing";
  // If the fit followed a row, its residual variance would be rounding error; this does not occur here.
  EXPECT_LT((a.residual_variance - (e.covariance - c.jacobian * p * c.jacobian.transpose()).diagonal()).norm(), 1e-9);
}

TEST(Adjustment, WhatIsConsideredDoesNotShrinkTheResidualsItIsNotFittedTo) {
  const Example e = example(8, 5);
  kernel::Parameters parameters = loose(), fixed = parameters;
  parameters.role[3] = kernel::Role::considered, fixed.role[3] = kernel::Role::fixed;
  EXPECT_EQ(adjust(e.conditions, parameters).residual_variance, adjust(e.conditions, fixed).residual_variance);
}

TEST(Adjustment, DeviationIsTheChiSquareSavedByLeavingRowsOut) {
  Example e = example(10, 7);
  Conditions& with = e.conditions;
  with.blocks[9].coupling = MatrixXd();  // the rest keeps its covariance without this block
  Conditions without = with;
  without.blocks[9].covariance *= 1e12;
  const auto total = [](const Adjustment& a) { return a.solution.chi2 + a.solution.x.squaredNorm() / 1e4; };  // includes the priors
  for (const double shift : {0.0, 1000.0}) {  // within the range of double and beyond it
    with.value[28] += shift;
    without.value[28] += shift;
    const Adjustment all = adjust(with, loose());
    const double saved = total(all) - total(adjust(without, loose()));
    const kernel::Deviation deviation = deviation_of(with, all, {27, 28, 29});
    EXPECT_EQ(deviation.degrees_of_freedom, 3);
    EXPECT_NEAR(deviation.chi2, saved, 1e-6 * saved);  // the remaining weight is 1e-12
    // chi-square with 3 degrees of freedom: P(X > x) = erfc(sqrt(x/2)) + sqrt(2x/pi) exp(-x/2); far out only the second term
    const double x = deviation.chi2;
    const double log_tail =
        shift == 0 ? std::log(std::erfc(std::sqrt(x / 2)) + std::sqrt(2 * x / M_PI) * std::exp(-x / 2)) : 0.5 * std::log(2 * x / M_PI) - x / 2;
    EXPECT_NEAR(deviation.log_probability(endless), log_tail, 1e-9 * std::abs(log_tail) + 1e-9);
  }
  EXPECT_EQ(deviation_of(with, adjust(with, loose()), {}).log_probability(endless), 0) << "nothing is not suspicious";
}

TEST(Adjustment, ASpreadFromFewResidualsMakesOutliersLessSure) {
  const kernel::Deviation deviation{20, 2};
  EXPECT_NEAR(deviation.log_probability(endless), -10, 1e-12);  // exp(-x/2)
  // F with (2, d) degrees of freedom: P(F > f) = (1 + 2 f / d)^(-d/2)
  EXPECT_NEAR(deviation.log_probability(10), -5 * std::log(1 + 2.0 * 10 / 10), 1e-9);
}

TEST(Adjustment, SpreadIsFoundWhereThereIsAndOnlyThere) {
  // 600 independent rows of unit noise and a spread of 2: variance 5. The estimate of the variance 5 has a relative sigma of sqrt(2/600) = 5.8 %.
  const int rows = 600;
  const auto with_spread = [&](double spread) {
    const RandomStream noise(11, "noise"), extra(11, "extra");
    Conditions c(rows, 2);
    for (Index i = 0; i < rows; ++i) {
      c.value[i] = noise.normal(static_cast<std::uint64_t>(i)) + spread * extra.normal(static_cast<std::uint64_t>(i));
      c.jacobian(i, 0) = 1;
      c.jacobian(i, 1) = std::sin(0.1 * static_cast<double>(i));
      c.blocks.push_back({i, 1, MatrixXd::Ones(1, 1), {}});
    }
    c.kind.assign(rows, Kind::rotation);
    return c;
  };
  const Conditions quiet = with_spread(0), loud = with_spread(2);
  const kernel::Parameters prior(2);
  EXPECT_FALSE(spread_is_significant(quiet, adjust(quiet, prior), Kind::rotation));
  EXPECT_TRUE(spread_is_significant(loud, adjust(loud, prior), Kind::rotation));
  EXPECT_FALSE(spread_is_significant(loud, adjust(loud, prior), Kind::gravity)) << "no such rows";
  const double found = estimate_spread(loud, adjust(loud, prior), Kind::rotation, 0);
  EXPECT_NEAR(1 + found * found, 5, 3.3 * 0.058 * 5);  // 99.9 %
  EXPECT_NEAR(redundancy(loud, adjust(loud, prior), Kind::rotation), rows - 2, 1e-6);
}

}  // namespace
}  // namespace imulab::rests
