#include "imulab/estimate/kernel/information.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace imulab::kernel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index columns, std::uint64_t seed) {
  const RandomStream draws(seed, "information");
  std::uint64_t next = 0;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return draws.normal(next++); });
}

TEST(Solve, EqualsTheNormalEquationsWithPriors) {
  const MatrixXd j = random_matrix(30, 4, 1);
  const VectorXd e = random_matrix(30, 1, 2);
  Parameters parameters(4);
  parameters.sigma << no_prior, 0.1, no_prior, 0.5;
  parameters.offset << 0, 0.3, 0, -0.2;
  const Solution s = solve(Information(j, e), parameters);
  const VectorXd weight = parameters.sigma.cwiseAbs2().cwiseInverse();
  const MatrixXd p = (j.transpose() * j + MatrixXd(weight.asDiagonal())).inverse();
  const VectorXd x = p * (weight.cwiseProduct(parameters.offset) - j.transpose() * e);
  // The solution is exact except for rounding of well-conditioned matrices.
  EXPECT_LT((s.x - x).norm(), 1e-12);
  EXPECT_LT((s.covariance - p).norm(), 1e-12 * p.norm());
  EXPECT_NEAR(s.chi2, (e + j * x).squaredNorm(), 1e-11 * s.chi2);
  EXPECT_NEAR(s.degrees_of_freedom, 30 - (j * p * j.transpose()).trace(), 1e-11);
}

TEST(Solve, WhatIsHeldTakesItsPriorValueAsExact) {
  const MatrixXd j = random_matrix(30, 4, 3);
  const VectorXd e = random_matrix(30, 1, 4);
  Parameters parameters(4);
  parameters.role[2] = Role::fixed, parameters.offset[2] = 0.7;
  const Solution s = solve(Information(j, e), parameters);
  EXPECT_EQ(s.x[2], 0.7);
  EXPECT_EQ(s.covariance.row(2).norm(), 0);
  const std::vector<Index> others{0, 1, 3};
  const VectorXd x =
      (j(Eigen::all, others).transpose() * j(Eigen::all, others)).inverse() * -j(Eigen::all, others).transpose() * (e + 0.7 * j.col(2));
  EXPECT_LT((s.x(others) - x).norm(), 1e-12);
}

TEST(Solve, WhatIsConsideredCountsAsNoiseOfTheData) {
  const MatrixXd j = random_matrix(30, 4, 5);
  const VectorXd e = random_matrix(30, 1, 6);
  Parameters parameters(4), fixed(4);
  parameters.role[3] = Role::considered, fixed.role[3] = Role::fixed;
  parameters.sigma[3] = 0.4, parameters.offset[3] = fixed.offset[3] = 0.2;
  const Solution s = solve(Information(j, e), parameters), exact = solve(Information(j, e), fixed);
  EXPECT_LT((s.x - exact.x).norm(), 1e-12) << "the estimate is that with the parameter at its prior value";
  EXPECT_NEAR(s.covariance(3, 3), 0.16, 1e-12);
  // The errors of the estimate come from the data's noise and the considered parameter: P (J^T J + J^T j3 0.16 j3^T J) P.
  const MatrixXd known = j.leftCols(3), p = (known.transpose() * known).inverse();
  const VectorXd leak = p * known.transpose() * j.col(3);
  EXPECT_LT((s.covariance.topLeftCorner(3, 3) - p - 0.16 * leak * leak.transpose()).norm(), 1e-12);
  EXPECT_LT((s.covariance.col(3).head(3) + 0.16 * leak).norm(), 1e-12);
}

TEST(Correction, IsThatOfTheSolution) {
  const Information data(random_matrix(30, 5, 8), random_matrix(30, 1, 9));
  Parameters parameters(5);
  parameters.sigma << no_prior, 0.1, 0.3, no_prior, 0.5;
  parameters.offset << 0, 0.3, -0.4, 0.7, -0.2;
  parameters.role[2] = Role::considered, parameters.role[3] = Role::fixed;
  EXPECT_LT((correction(data, parameters) - solve(data, parameters).x).norm(), 1e-12);
}

TEST(Solve, SaysWhatIsNotDetermined) {
  MatrixXd j = random_matrix(30, 3, 7);
  j.col(2) = j.col(1);
  EXPECT_THROW(correction(Information(j, VectorXd::Zero(30)), Parameters(3), "the points"), Unsupported);
  EXPECT_THROW(solve(Information(j, VectorXd::Zero(30)), Parameters(3), "the points"), Unsupported);
  Parameters parameters(3);
  parameters.sigma.setConstant(10);
  const Solution s = solve(Information(j, VectorXd::Zero(30)), parameters);
  const VectorXd needed = VectorXd::Constant(3, 5);
  EXPECT_EQ(undetermined(s.covariance, parameters, needed), (std::vector<Index>{1, 2}));
  EXPECT_GT(condition_number(Information(j, VectorXd::Zero(30)), parameters), 10);
}

TEST(Information, IsAdditive) {
  const MatrixXd j = random_matrix(30, 3, 8);
  const VectorXd e = random_matrix(30, 1, 9);
  Information sum(j.topRows(10), e.head(10));
  sum += Information(j.bottomRows(20), e.tail(20));
  const VectorXd x = random_matrix(3, 1, 10);
  EXPECT_NEAR(sum.at(x), (e + j * x).squaredNorm(), 1e-11 * sum.at(x));
  EXPECT_NEAR((sum - Information(j.topRows(10), e.head(10))).at(x), (e + j * x).tail(20).squaredNorm(), 1e-11 * sum.at(x));
  EXPECT_EQ(sum.rows, 30);
}

TEST(ConditionNumber, IsThatOfTheCorrelations) {
  MatrixXd m(2, 2);
  m << 4, 2 * 0.6, 2 * 0.6, 1;  // correlation 0.6: eigenvalues 1.6 and 0.4
  EXPECT_NEAR(condition_number(m), 2, 1e-12);
}

/// Many parameters, each coupled to a few others: the sparse factorization gives the same result as the dense one.
TEST(Solve, ManyParametersOfWhichEachMeetsAFew) {
  constexpr Index shared = 6, parts = 60, own = 2, rows = 9, all = shared + parts * own;
  MatrixXd jacobian = MatrixXd::Zero(parts * rows, all);
  for (Index k = 0; k < parts; ++k) {
    jacobian.block(k * rows, 0, rows, shared) = random_matrix(rows, shared, 100 + static_cast<std::uint64_t>(k));
    jacobian.block(k * rows, shared + k * own, rows, own) = random_matrix(rows, own, 200 + static_cast<std::uint64_t>(k));
  }
  const VectorXd residual = random_matrix(parts * rows, 1, 3);
  Parameters parameters(all);
  parameters.sigma[3] = 0.1;
  parameters.role[5] = Role::fixed;
  parameters.offset[5] = 0.2;
  const Information data(jacobian, residual);
  const Solution s = solve(data, parameters, "the test");
  std::vector<Index> loose;
  for (Index i = 0; i < all; ++i)
    if (i != 5) loose.push_back(i);
  MatrixXd normal = data.N(loose, loose);
  normal(3, 3) += 100;
  const MatrixXd expected = normal.fullPivLu().inverse();
  EXPECT_LT((s.covariance(loose, loose) - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LT((normal * VectorXd(s.x(loose)) + VectorXd((data.g + 0.2 * data.N.col(5))(loose))).norm(), 1e-10 * data.g.norm());
  EXPECT_EQ(s.x[5], 0.2);
  parameters.sigma[3] = no_prior;
  jacobian.col(all - 1).setZero();
  EXPECT_THROW(solve(Information(jacobian, residual), parameters, "the test"), Unsupported) << "one parameter that no row shows";
}

TEST(Solve, WithoutTheNormalEquationsItIsTheSame) {
  const MatrixXd jacobian = random_matrix(30, 6, 1);
  const VectorXd residual = random_matrix(30, 1, 2);
  Parameters parameters(6);
  parameters.sigma[1] = 0.1, parameters.offset[1] = 0.05;
  parameters.sigma[3] = 0.2, parameters.offset[3] = -0.1, parameters.role[3] = Role::considered;
  parameters.role[5] = Role::fixed, parameters.offset[5] = 0.3;
  const Solution expected = solve(Information(jacobian, residual), parameters), s = solve(jacobian, residual, parameters);
  EXPECT_TRUE(s.x.isApprox(expected.x, 1e-12));
  EXPECT_TRUE(s.covariance.isApprox(expected.covariance, 1e-12));
  EXPECT_NEAR(s.chi2, expected.chi2, 1e-12 * expected.chi2);
  EXPECT_NEAR(s.degrees_of_freedom, expected.degrees_of_freedom, 1e-12);
  EXPECT_NEAR(condition_number(jacobian, parameters), condition_number(Information(jacobian, residual), parameters), 1e-9);
  parameters.role[3] = Role::estimated, parameters.offset.setZero();
  const MatrixXd by_residuals = gain(jacobian, parameters);
  EXPECT_TRUE((-by_residuals * residual).isApprox(solve(jacobian, residual, parameters).x, 1e-12));
}

/// x + y is known to 1, x - y to 1e-8: the squares differ by a factor of 1e16, which normal equations cannot represent.
TEST(Solve, WithoutTheNormalEquationsItKeepsWhatTheSquaresLose) {
  constexpr double much = 1e8;
  MatrixXd jacobian(2, 2);
  jacobian << 1, 1, much, -much;
  const VectorXd residual = VectorXd::Zero(2);
  const MatrixXd covariance = solve(jacobian, residual, Parameters(2)).covariance;
  EXPECT_NEAR(covariance(0, 0), 0.25 * (1 + 1e-16), 1e-7) << "rounding, times the ratio";
  EXPECT_NEAR((covariance(0, 0) + covariance(1, 1) + 2 * covariance(0, 1)), 1, 1e-7);
  EXPECT_THROW(solve(Information(jacobian, residual), Parameters(2)), Unsupported);
  jacobian.row(0) *= 1e-8;
  jacobian(0, 1) *= -1;
  EXPECT_THROW(solve(jacobian, residual, Parameters(2), "the test"), Unsupported) << "twice the same direction";
}

}  // namespace
}  // namespace imulab::kernel
