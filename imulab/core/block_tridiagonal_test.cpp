#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace imulab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd drawn(Index rows, Index cols, std::uint64_t seed) {
  MatrixXd out(rows, cols);
  RandomStream(seed, "block tridiagonal").normals(0, {out.data(), static_cast<std::size_t>(out.size())});
  return out;
}

/// Blocks of 2, 3 and 1 rows; the last is not coupled.
struct Example {
  MatrixXd dense = MatrixXd::Zero(6, 6);
  BlockTridiagonal blocks;
  Example() {
    const MatrixXd mixed = drawn(5, 5, 1);
    dense.topLeftCorner(5, 5) = mixed * mixed.transpose() + MatrixXd::Identity(5, 5);
    dense(5, 5) = 4;
    blocks = {{0, 2, dense.topLeftCorner(2, 2), {}}, {2, 3, dense.block(2, 2, 3, 3), dense.block(2, 0, 3, 2)}, {5, 1, dense.block(5, 5, 1, 1), {}}};
  }
};

TEST(BlockTridiagonal, HasTheElementsOfTheDenseMatrix) {
  const Example e;
  const std::vector<Index> rows{5, 0, 3, 2};
  EXPECT_EQ(part_of(e.blocks, rows), MatrixXd(e.dense(rows, rows)));
  EXPECT_EQ(variances(e.blocks), e.dense.diagonal());
  EXPECT_EQ(variances({}).size(), 0);
}

TEST(BlockTridiagonal, WhitensAsTheDenseCholeskyFactor) {
  const Example e;
  const MatrixXd x = drawn(6, 2, 2);
  EXPECT_LT((whitened(e.blocks, x) - MatrixXd(e.dense.llt().matrixL().solve(x))).norm(), 1e-12);  // rounding
}

}  // namespace
}  // namespace imulab
