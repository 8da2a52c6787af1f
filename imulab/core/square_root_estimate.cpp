#include "imulab/core/square_root_estimate.hpp"

#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

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
