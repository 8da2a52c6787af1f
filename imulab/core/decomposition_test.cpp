#include "imulab/core/decomposition.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace imulab {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd drawn_matrix(Eigen::Index rows, Eigen::Index columns) {
  MatrixXd m(rows, columns);
  std::srand(1);
  return m.setRandom();
}

MatrixXd covariance(Eigen::Index n) {
  const MatrixXd a = drawn_matrix(n, n + 3);
  return a * a.transpose();
}

// Matrices of 40 rows with condition below 1e4: what is multiplied back agrees to 1e-10.
TEST(Decomposition, CholeskyFactorsSolvesAndWhitens) {
  const MatrixXd a = covariance(40), b = drawn_matrix(40, 3);
  const Cholesky c(a);
  EXPECT_TRUE(c.positive_definite());
  EXPECT_TRUE((c.lower() * c.lower().transpose()).isApprox(a, 1e-13));
  EXPECT_EQ(c.lower()(0, 1), 0);
  EXPECT_TRUE((a * c.solve(b)).isApprox(b, 1e-10));
  EXPECT_TRUE(c.solve(VectorXd(b.col(1))).isApprox(c.solve(b).col(1), 1e-10));
  EXPECT_TRUE((a * c.inverse()).isApprox(MatrixXd::Identity(40, 40), 1e-10));
  EXPECT_TRUE((c.lower() * c.solve_lower(b)).isApprox(b, 1e-12));
  EXPECT_TRUE((c.lower().transpose() * c.solve_upper(b)).isApprox(b, 1e-12));
  MatrixXd indefinite = a;
  indefinite(5, 5) = -1;
  EXPECT_FALSE(Cholesky(indefinite).positive_definite());
}

TEST(Decomposition, OrthogonalTimesTriangularGivesTheFactorOfTheSquare) {
  const MatrixXd a = drawn_matrix(40, 12);
  const OrthogonalTriangular f = orthogonal_triangular(a);
  EXPECT_TRUE((f.Q * f.R).isApprox(a, 1e-13));
  EXPECT_TRUE((f.Q.transpose() * f.Q).isApprox(MatrixXd::Identity(12, 12), 1e-13));
  EXPECT_TRUE(f.R.transpose().isApprox(Cholesky(a.transpose() * a).lower(), 1e-10));
  EXPECT_TRUE(Cholesky::of_lower(f.R.transpose()).inverse().isApprox(Cholesky(a.transpose() * a).inverse(), 1e-10));
}

TEST(Decomposition, ASemidefiniteMatrixIsSolvedWhereItCanBe) {
  const MatrixXd a = covariance(20);
  const VectorXd b = drawn_matrix(20, 1);
  EXPECT_TRUE((a * solve_semidefinite(a, b)).isApprox(b, 1e-10));
  EXPECT_NEAR(squared_norm_in(a, b), b.dot(inverse_of(a) * b), 1e-9 * squared_norm_in(a, b));
  MatrixXd singular = MatrixXd::Zero(3, 3);
  singular.diagonal() << 2, 0, 4;
  EXPECT_TRUE(solve_semidefinite(singular, VectorXd(Eigen::Vector3d(2, 0, 4))).isApprox(Eigen::Vector3d(1, 0, 1)));
}

TEST(Decomposition, EigenvaluesAreAscendingAndSingularValuesDescending) {
  const MatrixXd a = covariance(20);
  const SymmetricEigen e = symmetric_eigen(a);
  EXPECT_TRUE((e.vectors * e.values.asDiagonal() * e.vectors.transpose()).isApprox(a, 1e-12));
  EXPECT_LT(e.values[0], e.values[19]);
  EXPECT_TRUE(symmetric_eigenvalues(a).isApprox(e.values, 1e-12));
  const MatrixXd tall = drawn_matrix(30, 4);
  const SingularValues s = singular_values(tall);
  EXPECT_TRUE((s.U * s.values.asDiagonal() * s.V.transpose()).isApprox(tall, 1e-12));
  EXPECT_GT(s.values[0], s.values[3]);
}

TEST(Decomposition, LeastSquaresSayWhatTheDataDetermine) {
  MatrixXd a = drawn_matrix(30, 4);
  const MatrixXd x = drawn_matrix(4, 2);
  const LeastSquares full = least_squares(a, a * x);
  EXPECT_EQ(full.rank, 4);
  EXPECT_TRUE(full.x.isApprox(x, 1e-12));
  a.col(3) = a.col(0) + 1e-6 * VectorXd(a.col(3));
  EXPECT_EQ(least_squares(a, a * x).rank, 4);
  EXPECT_EQ(least_squares(a, a * x, 1e-3).rank, 3);
}

TEST(Decomposition, ARankTestRefusesDependentColumns) {
  const MatrixXd a = drawn_matrix(8, 3);
  const VectorXd x = drawn_matrix(3, 1);
  const auto found = solve_full_rank(a, a * x, 1e-2);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - x).norm(), 1e-12);  // rounding
  MatrixXd dependent = a;
  dependent.col(2) = 2 * a.col(0) - a.col(1);
  EXPECT_FALSE(solve_full_rank(dependent, a * x, 1e-2));
  EXPECT_FALSE(solve_full_rank(a.topRows(2), x.head(2), 1e-2)) << "fewer rows than columns";
}

TEST(Decomposition, ReverseCholeskyIsOfTheOtherOrder) {
  const MatrixXd mixed = drawn_matrix(4, 4), a = mixed * mixed.transpose() + MatrixXd::Identity(4, 4);
  const auto lower = reverse_cholesky(a);
  ASSERT_TRUE(lower);
  EXPECT_LT((lower->transpose() * *lower - a).norm(), 1e-12);  // rounding
  EXPECT_TRUE(lower->isLowerTriangular());
  EXPECT_FALSE(reverse_cholesky(-a));
}

TEST(Decomposition, APartOfACovarianceIsNoMoreThanAllOfIt) {
  MatrixXd whole(2, 2), part(2, 2);
  whole << 4, 1, 1, 2;
  part << 6, 0, 0, 0.5;
  const MatrixXd limited = limited_part(part, whole);
  EXPECT_GT(MatrixXd(whole - limited).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
  EXPECT_LT((limited_part(0.3 * whole, whole) - 0.3 * whole).norm(), 1e-12);
  EXPECT_LT((common_part(whole, whole) - whole).norm(), 1e-12);
  EXPECT_LT((common_part(0.3 * whole, whole) - 0.3 * whole).norm(), 1e-12);
  for (const MatrixXd& all : {whole, part})
    EXPECT_GT(MatrixXd(all - common_part(whole, part)).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
  EXPECT_EQ(limited_part(MatrixXd(0, 0), MatrixXd(0, 0)).size(), 0);  // nothing is stated
}

}  // namespace
}  // namespace imulab
