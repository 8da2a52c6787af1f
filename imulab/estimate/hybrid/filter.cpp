#include "imulab/estimate/hybrid/filter.hpp"

#include "imulab/estimate/hybrid/navigator.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <cmath>
#include <limits>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The estimate and the lower triangular factor of its covariance.
struct Estimate {
  VectorXd x;
  MatrixXd factor;
};

/// Constants keep their rows; those of attitude and velocity follow the transition, and their last columns take up the noise.
void predict(Estimate& e, const MatrixXd& transition, const Matrix6& noise) {
  e.x.tail<6>() = (transition * e.x).eval();
  const Index constants = e.x.size() - 6;
  const MatrixXd rows = transition * e.factor.triangularView<Eigen::Lower>();
  e.factor.bottomLeftCorner(6, constants) = rows.leftCols(constants);
  Eigen::Matrix<double, 12, 6> both;
  both.topRows<6>() = rows.rightCols<6>().transpose();
  both.bottomRows<6>() = Matrix6(noise.llt().matrixL()).transpose();
  const Eigen::HouseholderQR<Eigen::Matrix<double, 12, 6>> qr(both);
  e.factor.bottomRightCorner<6, 6>() = Matrix6(qr.matrixQR().topRows<6>().triangularView<Eigen::Upper>()).transpose();
}

/// One observed state, with a standard deviation that may be zero: Carlson's (1973) update of the factor, from the last column to the first.
void update(Estimate& e, Index state, double value, double sigma) {
  const Index n = e.x.size();
  const VectorXd f = e.factor.row(state).transpose();
  VectorXd sum = VectorXd::Zero(n);  // of f_k L_k over the columns done
  double before = sigma * sigma;
  for (Index j = state; j >= 0; --j) {
    const double after = before + f[j] * f[j];
    if (after > 0) {
      const Index m = n - j;
      const VectorXd column = e.factor.col(j).tail(m);
      const double shrink = std::sqrt(before / after), taken = before > 0 ? f[j] / std::sqrt(before * after) : 0;
      e.factor.col(j).tail(m) = shrink * column - taken * sum.tail(m);
      sum.tail(m) += f[j] * column;
    }
    before = after;
  }
  if (before > 0) e.x += sum * ((value - e.x[state]) / before);
}

/// Adds variance to one state: a factor's update by one vector.
void add_variance(Estimate& e, Index state, double variance) {
  VectorXd v = VectorXd::Zero(e.x.size());
  v[state] = std::sqrt(variance);
  for (Index j = state; j < v.size(); ++j) {
    if (v[j] == 0) continue;
    const double a = e.factor(j, j), r = std::hypot(a, v[j]), c = a / r, s = v[j] / r;
    const Index m = v.size() - j;
    const VectorXd column = e.factor.col(j).tail(m);
    e.factor.col(j).tail(m) = c * column + s * v.tail(m);
    v.tail(m) = (c * v.tail(m) - s * column).eval();
  }
}

/// Observes the velocity after a block, unless its innovation is beyond `outlier`. Returns the innovation's chi-square.
double observe_velocity(Estimate& e, const Vector3d& velocity, double sigma, double outlier) {
  const Index at = e.x.size() - 3;
  const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = e.factor.bottomRows<3>();
  const Matrix3d s = rows * rows.transpose() + sigma * sigma * Matrix3d::Identity();
  const double chi2 = Vector3d(s.llt().matrixL().solve(velocity - e.x.tail<3>())).squaredNorm();
  if (chi2 <= outlier)
    for (Index i = 2; i >= 0; --i) update(e, at + i, velocity[i], sigma);
  return chi2;
}

/// A new attitude with standard deviation `sigma`; the first one is also that of the start.
void begin(Estimate& e, const States& states, const Vector3d& sigma, bool first) {
  e.x.tail<6>().setZero();
  e.factor.bottomRows<6>().setZero();
  const Index column = first ? states.first(Group::start) : states.attitude();
  for (Index i = 0; i < 3; ++i) e.factor(states.attitude() + i, column + i) = sigma[i];
}

/// Block k, from which the motion was measured without interruption, and the rest it belongs to.
Range rest_from(const std::vector<Block>& blocks, std::size_t k) {
  Range rest = blocks[k].samples;
  for (; k < blocks.size() && blocks[k].at_rest; ++k) rest.end = blocks[k].samples.end;
  return rest;
}

}  // namespace

Pass filter_pass(const Data& data, const Linearization& about, const States& states, const kernel::Parameters& known, const PassOptions& options) {
  const std::vector<Block>& blocks = data.blocks;
  const Noise& noise = data.noise;
  const Recording readings = compensated(data.recording, blocks, about.model);
  Navigator navigator(readings, about.place, states);
  Estimate e{VectorXd::Zero(states.size()), MatrixXd::Zero(states.size(), states.size())};
  e.x.head(states.constants()) = known.offset;
  e.factor.diagonal().head(states.constants()) = known.sigma;
  Pass out;
  Vector3d velocity = Vector3d::Zero();  // computed
  double next_point = -std::numeric_limits<double>::infinity();
  std::size_t first = 0;  // sample since which the motion was measured without interruption

  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const Block& block = blocks[k];
    if (k == 0 || block.lost) {
      navigator.align(rest_from(blocks, k));
      if (k == 0) out.start = navigator.C_nb = about.start.value_or(navigator.C_nb);
      first = block.samples.begin;
      velocity.setZero();
      begin(e, states, k == 0 ? Vector3d(known.sigma.segment<3>(states.first(Group::start))) : alignment_sigma(), k == 0);
    }
    const Matrix3d before = navigator.C_nb;
    const BlockSums sums = navigator.over(block, first);
    velocity += sums.velocity;
    predict(e, transition(sums, states, about.place), process_noise(sums, noise, 0.5 * (before + navigator.C_nb)));
    for (Index i = 0; i < 3; ++i) {
      if (noise.accel_walk[i] > 0) add_variance(e, states.first(Group::accel_offset) + i, sums.duration * noise.accel_walk[i] * noise.accel_walk[i]);
      if (noise.gyro_walk[i] > 0) add_variance(e, states.first(Group::gyro_offset) + i, sums.duration * noise.gyro_walk[i] * noise.gyro_walk[i]);
    }
    out.chi2.push_back(block.observed ? observe_velocity(e, velocity, noise.velocity, options.outlier) : 0);
    if (block.observed && out.chi2.back() <= options.outlier) {  // the known velocity error goes into the solution
      velocity -= e.x.tail<3>();
      e.x.tail<3>().setZero();
    }
    const double time = readings.time_s(block.samples.end - 1);
    if (options.curve_interval > 0 && (time >= next_point || k + 1 == blocks.size())) {
      out.curve.push_back({time, e.x, e.factor.rowwise().norm()});
      next_point = time + options.curve_interval;
    }
  }
  out.x = e.x;
  out.covariance = e.factor * e.factor.transpose();
  return out;
}

}  // namespace imulab::hybrid
