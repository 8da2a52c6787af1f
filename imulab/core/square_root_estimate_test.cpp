#include "imulab/core/decomposition.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(SquareRootEstimate, IsTheKalmanFilterOfTheCovariance) {
  SquareRootEstimate e(3);
  e.x << 0.5, -1, 2;
  e.factor.diagonal() << 3, 1, 2;
  Vector3d x = e.x;
  Matrix3d P = e.factor * e.factor.transpose(), F = Matrix3d::Identity(), Q = Matrix3d::Zero();
  const Eigen::Matrix<double, 2, Eigen::Dynamic> transition{{0.5, 1, 0.2}, {-0.3, 0, 0.9}};
  const Eigen::Matrix<double, 2, 3> noise{{0.2, 0.1, -0.3}, {0.1, 0.3, 0.2}};
  F.bottomRows<2>() = transition, Q.bottomRightCorner<2, 2>() = noise * noise.transpose();

  e.predict(transition, noise);
  x = F * x, P = F * P * F.transpose() + Q;
  EXPECT_LT((e.factor * e.factor.transpose() - P).norm(), 1e-14 * P.norm());

  e.observe(1, 0.7, 0.1);
  const Vector3d gain = P.col(1) / (P(1, 1) + 0.01);
  x += gain * (0.7 - x[1]), P -= gain * P.row(1).eval();
  EXPECT_LT((e.x - x).norm(), 1e-14 * x.norm());
  EXPECT_LT((e.factor * e.factor.transpose() - P).norm(), 1e-14 * P.norm());

  e.add_variance(0, 4);
  P(0, 0) += 4;
  EXPECT_LT((e.factor * e.factor.transpose() - P).norm(), 1e-14 * P.norm());
  EXPECT_TRUE(e.factor.isLowerTriangular(1e-15));
}

TEST(SquareRootEstimate, AnExactObservationLeavesNoVariance) {
  SquareRootEstimate e(2);
  e.factor << 1e6, 0, 1e6, 1e-3;
  e.observe(1, 5, 0);
  EXPECT_DOUBLE_EQ(e.x[1], 5);
  EXPECT_NEAR(e.factor.row(1).norm(), 0, 1e-9);
  EXPECT_NEAR(e.factor.row(0).norm(), 1e-3, 1e-9);
}

}  // namespace
}  // namespace imulab
