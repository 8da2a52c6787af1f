#include "imulab/core/block_tridiagonal.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <iterator>
#include <utility>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

double element(const BlockTridiagonal& blocks, Index a, Index b) {
  if (a < b) std::swap(a, b);
  const auto after = std::upper_bound(blocks.begin(), blocks.end(), a, [](Index i, const CovarianceBlock& block) { return i < block.first; });
  if (after == blocks.begin()) return 0;
  const CovarianceBlock& block = *std::prev(after);
  if (a >= block.first + block.size) return 0;
  if (b >= block.first) return block.covariance(a - block.first, b - block.first);
  if (block.coupling.size() == 0) return 0;
  const CovarianceBlock& before = *std::prev(after, 2);
  return b >= before.first ? block.coupling(a - block.first, b - before.first) : 0;
}

}  // namespace

Eigen::VectorXd variances(const BlockTridiagonal& blocks) {
  Eigen::VectorXd out(blocks.empty() ? 0 : blocks.back().first + blocks.back().size);
  for (const CovarianceBlock& block : blocks) out.segment(block.first, block.size) = block.covariance.diagonal();
  return out;
}

MatrixXd part_of(const BlockTridiagonal& blocks, const std::vector<Index>& rows) {
  const auto n = static_cast<Index>(rows.size());
  const auto place = [&](Index i) { return rows[static_cast<std::size_t>(i)]; };
  return MatrixXd::NullaryExpr(n, n, [&](Index a, Index b) { return element(blocks, place(a), place(b)); });
}

MatrixXd whitened(const BlockTridiagonal& blocks, MatrixXd x) {
  MatrixXd factor;  // of the block before
  Index first = 0, size = 0;
  for (const CovarianceBlock& block : blocks) {
    MatrixXd own = block.covariance;
    MatrixXd right = x.middleRows(block.first, block.size);
    if (block.coupling.size() > 0) {
      const MatrixXd coupled = factor.triangularView<Eigen::Lower>().solve(block.coupling.transpose()).transpose();
      own -= coupled * coupled.transpose();
      right -= coupled * x.middleRows(first, size);
    }
    factor = own.llt().matrixL();
    first = block.first, size = block.size;
    x.middleRows(first, size) = factor.triangularView<Eigen::Lower>().solve(right);
  }
  return x;
}

}  // namespace imulab
