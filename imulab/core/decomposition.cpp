#include "imulab/core/decomposition.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace imulab {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Cholesky::Cholesky(const MatrixXd& a) {
  const Eigen::LLT<MatrixXd> factor(a);
  lower_ = factor.matrixL();
  positive_definite_ = factor.info() == Eigen::Success;
}

Cholesky Cholesky::of_lower(MatrixXd lower) {
  Cholesky out;
  out.positive_definite_ = (lower.diagonal().array() > 0).all();
  out.lower_ = std::move(lower);
  return out;
}

namespace {
constexpr Eigen::Index at_once = 48;  // columns
}

MatrixXd Cholesky::inverse_lower() const {
  const Eigen::Index n = lower_.rows();
  MatrixXd root = MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; j += at_once) {
    const Eigen::Index width = std::min(at_once, n - j), rest = n - j;
    root.block(j, j, width, width).setIdentity();
    auto columns = root.block(j, j, rest, width);
    lower_.bottomRightCorner(rest, rest).triangularView<Lower>().solveInPlace(columns);
  }
  return root;
}

// L^-1, then L^-T L^-1, by columns: what is zero by the triangle takes no time.
MatrixXd Cholesky::inverse() const {
  const Eigen::Index n = lower_.rows();
  const MatrixXd root = inverse_lower();
  MatrixXd out(n, n);
  for (Eigen::Index j = 0; j < n; j += at_once) {
    const Eigen::Index width = std::min(at_once, n - j), rest = n - j;
    out.block(j, 0, width, j + width).noalias() = root.block(j, j, rest, width).transpose() * root.block(j, 0, rest, j + width);
  }
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

void Cholesky::forward(VectorXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::forward(MatrixXd& x) const { lower_.triangularView<Lower>().solveInPlace(x); }

void Cholesky::backward(VectorXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

void Cholesky::backward(MatrixXd& x) const { lower_.triangularView<Lower>().transpose().solveInPlace(x); }

MatrixXd inverse_of(const MatrixXd& a) { return a.inverse(); }

std::optional<Eigen::Matrix3d> regular_inverse(const Eigen::Matrix3d& a) {
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(a);
  return lu.isInvertible() ? std::optional(Eigen::Matrix3d(lu.inverse())) : std::nullopt;
}

MatrixXd solve_semidefinite(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

VectorXd solve_semidefinite(const MatrixXd& a, const VectorXd& b) { return a.ldlt().solve(b); }

double squared_norm_in(const MatrixXd& a, const VectorXd& b) { return b.dot(solve_semidefinite(a, b)); }

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& a) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues(); }

SingularValues singular_values(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

OrthogonalTriangular orthogonal_triangular(const MatrixXd& a) {
  const Eigen::HouseholderQR<MatrixXd> qr(a);
  OrthogonalTriangular out{qr.householderQ() * MatrixXd::Identity(a.rows(), a.cols()),
                           qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>()};
  for (Eigen::Index i = 0; i < a.cols(); ++i)
    if (out.R(i, i) < 0) out.R.row(i) *= -1, out.Q.col(i) *= -1;
  return out;
}

LeastSquares least_squares(const MatrixXd& a, const MatrixXd& b, std::optional<double> threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  if (threshold) qr.setThreshold(*threshold);
  return {qr.solve(b), qr.rank()};
}

std::optional<VectorXd> solve_full_rank(const MatrixXd& a, const VectorXd& b, double threshold) {
  if (a.rows() < a.cols()) return {};
  const VectorXd norm = a.colwise().norm();
  if (!(norm.minCoeff() > 1e-6 * norm.maxCoeff())) return {};
  const Eigen::JacobiSVD<MatrixXd> svd(a * norm.cwiseInverse().asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.singularValues().minCoeff() < threshold * svd.singularValues().maxCoeff()) return {};
  return norm.cwiseInverse().cwiseProduct(svd.solve(b));
}

std::optional<MatrixXd> reverse_cholesky(const MatrixXd& a) {
  const Cholesky factor(a.reverse());  // rows and columns
  if (!factor.positive_definite()) return {};
  return MatrixXd(factor.lower().transpose().reverse());
}

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

MatrixXd whitened(const BlockTridiagonal& blocks, MatrixXd x, double* log_determinant) {
  MatrixXd factor;  // of the block before
  if (log_determinant != nullptr) *log_determinant = 0;
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
    if (log_determinant != nullptr) *log_determinant += 2 * factor.diagonal().array().log().sum();
    first = block.first, size = block.size;
    x.middleRows(first, size) = factor.triangularView<Eigen::Lower>().solve(right);
  }
  return x;
}

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// W^1/2 f(W^-1/2 A W^-1/2) W^1/2 of a covariance W and a part A of it; f is of each eigenvalue, which is a share of W.
MatrixXd with_shares(const MatrixXd& part, const MatrixXd& whole, double (*f)(double share)) {
  constexpr double rounding = 1e-12;
  if (whole.size() == 0) return whole;
  const VectorXd sigma = whole.diagonal().cwiseSqrt(), per_sigma = (sigma.array() > 0).select(sigma.cwiseInverse(), 0.0);
  const SymmetricEigen all = symmetric_eigen(per_sigma.asDiagonal() * whole * per_sigma.asDiagonal());
  const VectorXd root = (all.values.array() > rounding).select(all.values.cwiseMax(0).cwiseSqrt(), 0.0);
  const VectorXd per_root = (root.array() > 0).select(root.cwiseInverse(), 0.0);
  const MatrixXd whitened = per_root.asDiagonal() * all.vectors.transpose() * per_sigma.asDiagonal();
  const SymmetricEigen share = symmetric_eigen(whitened * part * whitened.transpose());
  const MatrixXd back = sigma.asDiagonal() * all.vectors * root.asDiagonal() * share.vectors;
  return back * share.values.unaryExpr(f).asDiagonal() * back.transpose();
}

}  // namespace

MatrixXd limited_part(const MatrixXd& part, const MatrixXd& covariance) {
  return with_shares(part, covariance, [](double share) { return std::clamp(share, 0.0, 1.0); });
}

MatrixXd common_part(const MatrixXd& a, const MatrixXd& b) {
  return with_shares(a, a + b, [](double share) { return std::max(0.0, std::min(share, 1 - share)); });
}

void SquareRootEstimate::observe(Index state, double value, double sigma) {
  const Index n = x.size();
  const VectorXd f = factor.row(state).transpose();
  VectorXd sum = VectorXd::Zero(n);  // of f_k L_k over the columns done
  double before = sigma * sigma;
  for (Index j = state; j >= 0; --j) {
    const double after = before + f[j] * f[j];
    if (after > 0) {
      const Index m = n - j;
      const VectorXd column = factor.col(j).tail(m);
      const double shrink = std::sqrt(before / after), taken = before > 0 ? f[j] / std::sqrt(before * after) : 0;
      factor.col(j).tail(m) = shrink * column - taken * sum.tail(m);
      sum.tail(m) += f[j] * column;
    }
    before = after;
  }
  if (before > 0) x += sum * ((value - x[state]) / before);
}

void SquareRootEstimate::add_variance(Index state, double variance) {
  VectorXd v = VectorXd::Zero(x.size());
  v[state] = std::sqrt(variance);
  for (Index j = state; j < v.size(); ++j) {
    if (v[j] == 0) continue;
    const double a = factor(j, j), r = std::hypot(a, v[j]), c = a / r, s = v[j] / r;
    const Index m = v.size() - j;
    const VectorXd column = factor.col(j).tail(m);
    factor.col(j).tail(m) = c * column + s * v.tail(m);
    v.tail(m) = (c * v.tail(m) - s * column).eval();
  }
}

}  // namespace imulab
