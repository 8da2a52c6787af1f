#include "imulab/estimate/hybrid_filter.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid_navigator.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>

#include <cmath>
#include <limits>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

HybridLayout hybrid_layout(const HybridTerms& terms, bool latitude) {
  HybridLayout layout;
  const auto take = [&](bool wanted, Index& at, Index count) {
    if (!wanted) return;
    at = layout.constants;
    layout.constants += count;
  };
  take(latitude, layout.latitude, 1);
  take(terms.lever_arm, layout.lever_arm, 9);
  take(terms.quadratic, layout.quadratic, 3);
  take(terms.g_sensitivity, layout.g_sensitivity, 9);
  take(terms.delay, layout.delay, 1);
  return layout;
}

namespace {

using L = HybridLayout;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Attitude and velocity after the block from all states before it.
MatrixXd transition_of(const HybridSums& s, const HybridLayout& layout, const HybridSite& site) {
  MatrixXd t = MatrixXd::Zero(6, layout.size());  // rows: attitude, velocity
  t.block<3, 3>(0, layout.attitude()) = Matrix3d::Identity() - s.duration * skew<double>(earth_rate_enu(site.latitude));
  t.block<3, 3>(3, layout.attitude()) = s.force;
  t.block<3, 3>(3, layout.velocity()).setIdentity();
  const auto gyro = [&](Index column, std::size_t basis, Index axis) {
    t.block<3, 1>(0, column) = -s.gyro[basis].col(axis);
    t.block<3, 1>(3, column) = -s.gyro_velocity[basis].col(axis);
  };
  Index lower = L::accel_matrix;
  for (Index r = 0; r < 3; ++r) {
    gyro(L::gyro_offset + r, 0, r);
    t.block<3, 1>(3, L::accel_offset + r) = s.accel[0].col(r);
    for (Index c = 0; c < 3; ++c) {
      gyro(L::gyro_matrix + 3 * r + c, static_cast<std::size_t>(1 + c), r);
      if (layout.g_sensitivity >= 0) gyro(layout.g_sensitivity + 3 * r + c, static_cast<std::size_t>(4 + c), r);
      if (c <= r) t.block<3, 1>(3, lower++) = s.accel[static_cast<std::size_t>(1 + c)].col(r);
    }
  }
  t(5, L::gravity) = site.gravity * s.duration;
  if (layout.latitude >= 0) {
    const Vector3d by_latitude(0, -earth_rate * std::sin(site.latitude), earth_rate * std::cos(site.latitude));
    t.block<3, 1>(0, layout.latitude) = s.duration * by_latitude;
    t.block<3, 1>(3, layout.latitude) = 0.5 * s.duration * (s.force * by_latitude);
  }
  if (layout.quadratic >= 0) t.block<3, 3>(3, layout.quadratic) = s.quadratic;
  if (layout.lever_arm >= 0) t.block<3, 9>(3, layout.lever_arm) = s.lever_arm;
  if (layout.delay >= 0) t.block<3, 1>(3, layout.delay) = s.delay;
  return t;
}

/// Of attitude and velocity over a block, C the attitude in its middle.
Matrix6 process_noise(const HybridSums& s, const HybridNoise& noise, const Matrix3d& C) {
  const Matrix3d gyro = C * noise.gyro.cwiseAbs2().asDiagonal() * C.transpose(), accel = C * noise.accel.cwiseAbs2().asDiagonal() * C.transpose();
  const double T = s.duration;
  const Matrix3d force = s.force / T;  // [f_n x], constant within the block
  Matrix6 q;
  q.topLeftCorner<3, 3>() = T * gyro;
  q.bottomLeftCorner<3, 3>() = (T * T / 2) * force * gyro;
  q.topRightCorner<3, 3>() = q.bottomLeftCorner<3, 3>().transpose();
  q.bottomRightCorner<3, 3>() = T * accel + (T * T * T / 3) * force * gyro * force.transpose();
  return q;
}

/// The estimate and the lower triangular factor of its covariance.
struct Estimate {
  VectorXd x;
  MatrixXd factor;
};

/// Constants keep their rows; those of attitude and velocity follow the transition, and their last columns take in the noise.
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

/// One state as it is seen, with a standard deviation that may be zero: Carlson's update of the factor, from the last column to the first.
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

/// More variance of a state, its others' unchanged: a factor's update by one vector.
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

/// Velocity as it is seen after a block; returns the whitened innovation, or NaN where it is beyond `outlier` and left out.
Vector3d see_velocity(Estimate& e, const Vector3d& velocity, double sigma, double outlier) {
  const Index at = e.x.size() - 3;
  const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = e.factor.bottomRows<3>();
  const Matrix3d s = rows * rows.transpose() + sigma * sigma * Matrix3d::Identity();
  const Vector3d white = s.llt().matrixL().solve(velocity - e.x.tail<3>());
  if (!(white.squaredNorm() <= outlier)) return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (Index i = 2; i >= 0; --i) update(e, at + i, velocity[i], sigma);
  return white;
}

/// Attitude by an alignment: unknown to some degrees, the heading wholly. At the first one it is the start's, too.
void begin(Estimate& e, const HybridLayout& layout, const std::optional<Vector3d>& known, bool first) {
  const Vector3d spread = first && known ? *known : Vector3d(3 * unit::deg, 3 * unit::deg, 90 * unit::deg);
  e.x.tail<6>().setZero();
  e.factor.bottomRows<6>().setZero();
  for (Index i = 0; i < 3; ++i) {
    const double sigma = spread[i];
    if (first) {
      e.factor(L::start + i, L::start + i) = sigma;
      e.factor(layout.attitude() + i, L::start + i) = sigma;
    } else {
      e.factor(layout.attitude() + i, layout.attitude() + i) = sigma;
    }
  }
}

}  // namespace

HybridPass hybrid_pass(const Recording& recording, const std::vector<HybridBlock>& blocks, const SensorModel& model, const HybridSite& site,
                       const HybridNoise& noise, const HybridSettings& settings, const VectorXd& prior, const VectorXd& prior_sigma) {
  const HybridLayout& layout = settings.layout;
  const HybridSamples samples = compensated(recording, blocks, model);
  HybridNavigator navigator(samples, recording, site, layout);
  Estimate e{VectorXd::Zero(layout.size()), MatrixXd::Zero(layout.size(), layout.size())};
  e.x.head(layout.constants) = prior;
  e.factor.diagonal().head(layout.constants) = prior_sigma;
  HybridPass out;
  Vector3d velocity = Vector3d::Zero();  // computed
  double next_point = -std::numeric_limits<double>::infinity();
  std::size_t first = 0;  // sample since which the motion was seen without a break

  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const HybridBlock& block = blocks[k];
    if (k == 0 || block.lost) {
      Range rest = block.samples;  // to its end
      for (std::size_t m = k; m < blocks.size() && blocks[m].at_rest; ++m) rest.end = blocks[m].samples.end;
      navigator.align(rest);
      if (k == 0 && settings.start) navigator.C_nb = *settings.start;
      if (k == 0) out.start = navigator.C_nb;
      first = block.samples.begin;
      velocity.setZero();
      begin(e, layout, settings.start_sigma, k == 0);
    }
    const Matrix3d before = navigator.C_nb;
    const HybridSums sums = navigator.over(block, first);
    velocity += sums.velocity;
    predict(e, transition_of(sums, layout, site), process_noise(sums, noise, 0.5 * (before + navigator.C_nb)));
    for (Index i = 0; i < 3; ++i) {
      if (noise.accel_walk[i] > 0) add_variance(e, L::accel_offset + i, sums.duration * noise.accel_walk[i] * noise.accel_walk[i]);
      if (noise.gyro_walk[i] > 0) add_variance(e, L::gyro_offset + i, sums.duration * noise.gyro_walk[i] * noise.gyro_walk[i]);
    }
    Vector3d white = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (block.observed) white = see_velocity(e, velocity, noise.velocity, settings.outlier);
    out.innovation.push_back(white);
    out.chi2.push_back(white.squaredNorm());
    if (!std::isnan(white.x())) {  // what is known of the velocity's error goes into the solution
      velocity -= e.x.tail<3>();
      e.x.tail<3>().setZero();
    }
    const double time = recording.time_s(block.samples.end - 1);
    if (settings.curve_interval > 0 && (time >= next_point || k + 1 == blocks.size())) {
      out.curve.push_back({time, e.x, e.factor.rowwise().norm()});
      next_point = time + settings.curve_interval;
    }
  }
  out.x = e.x;
  out.covariance = e.factor * e.factor.transpose();
  return out;
}

}  // namespace imulab
