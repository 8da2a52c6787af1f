#include "imulab/navigation/aided/transition.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <cmath>

namespace imulab::aided {
namespace {

using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// The derivatives of the motion by all errors at the start, as they grow sample by sample.
class ErrorGrowth {
 public:
  explicit ErrorGrowth(const Problem& problem)
      : p_(problem), phi_(Rows::Zero(3, p_.sensors_end)), v_(phi_), r_(phi_), changes_(6, p_.terms ? p_.terms->sigma.size() : 0) {
    for (Eigen::Index k = 0; k < 3; ++k) phi_(k, At::attitude + k) = v_(k, At::velocity + k) = r_(k, At::position + k) = 1;
  }

  /// C_nb at the sample's middle, and the corrected sample.
  void add(std::size_t number, const Matrix3d& C, const Increment& sample, const NavigationState& state, const LocalEarth& earth) {
    const TimedIncrement& raw = p_.samples[number];
    const double dt = raw.interval;
    if (p_.terms) p_.terms->at(number, changes_);
    const Vector3d pushed = C * sample.velocity, turn = 2 * earth.rate + earth.transport_rate(state.velocity);
    Matrix3d transport = Matrix3d::Zero();  // of the transport rate by the velocity
    transport(0, 1) = -1 / earth.meridian_radius, transport(1, 0) = 1 / earth.transverse_radius;
    transport(2, 0) = earth.sin_latitude / earth.cos_latitude / earth.transverse_radius;
    const Rows before = v_;
    Rows turned = -dt * (skew<double>(turn - earth.rate) * phi_ + transport * v_);  // phi' = -w_in x phi - dw_in + C dw
    add_sensors(turned, C, raw, p_.gyro_offset, p_.gyro_matrix, p_.g_sensitivity);
    if (p_.terms) turned.middleCols(p_.terms_first, changes_.cols()) += dt * C * changes_.topRows<3>();
    v_ -= skew<double>(pushed) * (phi_ + turned / 2);  // dv' = -f x phi - (2 w_ie + w_en) x dv + dg + C df
    v_ -= dt * (skew<double>(turn) * before);
    v_.row(2) += dt * (-2 * earth.gravity.z() / earth.transverse_radius) * r_.row(2);
    Rows forced = Rows::Zero(3, p_.sensors_end);
    add_sensors(forced, C, raw, p_.accel_offset, p_.accel_matrix, -1);
    if (p_.terms) forced.middleCols(p_.terms_first, changes_.cols()) += dt * C * changes_.bottomRows<3>();
    v_ += forced;
    phi_ += turned;
    r_ += dt / 2 * (before + v_);
    pushed_ += pushed, interval_ += dt, mean_C_ += dt * C;
  }

  Transition finish() const {
    Transition t;
    t.motion.resize(9, p_.sensors_end);
    t.motion << phi_, v_, r_;
    t.interval = interval_;
    const Matrix3d C = mean_C_ / interval_, F = skew<double>(pushed_);
    const Matrix3d gyro = C * p_.gyro_noise.cwiseAbs2().asDiagonal() * C.transpose(),
                   accel = C * p_.accel_noise.cwiseAbs2().asDiagonal() * C.transpose();
    const double T = interval_;
    // White noise of the rate with the force constant over the interval: phi(t) is a walk, v its integral times -[f x], r that of v.
    const auto block = [](Matrix9& Q, Eigen::Index i, Eigen::Index j, const Matrix3d& value) {
      Q.block<3, 3>(i, j) = value;
      Q.block<3, 3>(j, i) = value.transpose();
    };
    block(t.gyro, 0, 0, T * gyro), block(t.gyro, 3, 0, -T / 2 * F * gyro), block(t.gyro, 6, 0, -T * T / 6 * F * gyro);
    const Matrix3d FgF = F * gyro * F.transpose();
    block(t.gyro, 3, 3, T / 3 * FgF), block(t.gyro, 6, 3, T * T / 8 * FgF), block(t.gyro, 6, 6, T * T * T / 20 * FgF);
    block(t.accel, 3, 3, T * accel), block(t.accel, 6, 3, T * T / 2 * accel), block(t.accel, 6, 6, T * T * T / 3 * accel);
    t.decay = Eigen::VectorXd::Ones(p_.size), t.driven = Eigen::VectorXd::Zero(p_.size);
    for (const StateBlock& b : p_.blocks) {
      if (std::isfinite(b.time)) {
        const double a = std::exp(-T / b.time);
        t.decay.segment(b.first, b.size).setConstant(a);
        t.driven.segment(b.first, b.size).setConstant(b.sigma * b.sigma * (1 - a * a));
      }
      if (b.walk.size() > 0) t.driven.segment(b.first, b.size) += T * b.walk.cwiseAbs2();
    }
    return t;
  }

 private:
  /// An offset acts over the time, element (i, j) of a matrix with what axis j reads.
  void add_sensors(Rows& rows, const Matrix3d& C, const TimedIncrement& raw, Eigen::Index offset, Eigen::Index matrix, Eigen::Index other) const {
    rows.middleCols<3>(offset) += raw.interval * C;
    const bool gyro = offset == p_.gyro_offset;
    for (Eigen::Index j = 0; j < 3; ++j) {
      if (matrix >= 0) rows.middleCols<3>(matrix + 3 * j) += (gyro ? raw.increment.angle : raw.increment.velocity)[j] * C;
      if (other >= 0) rows.middleCols<3>(other + 3 * j) += raw.increment.velocity[j] * C;
    }
  }

  const Problem& p_;
  Rows phi_, v_, r_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> changes_;
  Vector3d pushed_ = Vector3d::Zero();
  Matrix3d mean_C_ = Matrix3d::Zero();
  double interval_ = 0;
};

}  // namespace

Integrated integrate(const Problem& p, std::size_t begin, std::size_t end, const FullState& start, bool with_transition,
                     std::vector<NavigationState>* each) {
  const StrapdownOptions options{.gravity = p.gravity};
  Strapdown strapdown(start.motion, options);
  ErrorGrowth growth(p);
  LocalEarth earth = integration::earth_at(start.motion.latitude, start.motion.height, options);
  for (std::size_t i = begin; i < end; ++i) {
    const Increment sample = corrected(p, p.samples[i], start.x);
    if (with_transition) {
      const Matrix3d C = strapdown.state().q_nb.toRotationMatrix();
      growth.add(i, C + C * skew<double>(sample.angle / 2), sample, strapdown.state(), earth);
    }
    strapdown.step(sample, p.samples[i].interval);
    if (each) each->push_back(strapdown.state());
  }
  return {strapdown.state(), with_transition ? growth.finish() : Transition{}};
}

Matrix9 motion_noise(const Problem& p, const Transition& t) {
  return p.sources[p.gyro_source].factor * t.gyro + p.sources[p.accel_source].factor * t.accel;
}

Eigen::VectorXd slow_noise(const Problem& p, const Transition& t) {
  Eigen::VectorXd out = t.driven;
  for (const StateBlock& b : p.blocks)
    if (b.noise) out.segment(b.first, b.size) *= p.sources[*b.noise].factor;
  return out;
}

Eigen::VectorXd propagated_mean(const Transition& t, const Eigen::VectorXd& x) {
  Eigen::VectorXd out = t.decay.cwiseProduct(x);
  out.head<9>() = t.motion * x.head(t.motion.cols());
  return out;
}

Eigen::MatrixXd propagated(const Problem& p, const Transition& t, const Eigen::MatrixXd& P) {
  const Eigen::Index n = p.size, m = t.motion.cols();
  const Eigen::MatrixXd rows = t.motion * P.topRows(m);
  Eigen::MatrixXd out(n, n);
  out.bottomRightCorner(n - 9, n - 9) = t.decay.tail(n - 9).asDiagonal() * P.bottomRightCorner(n - 9, n - 9) * t.decay.tail(n - 9).asDiagonal();
  out.topRightCorner(9, n - 9) = rows.rightCols(n - 9) * t.decay.tail(n - 9).asDiagonal();
  out.bottomLeftCorner(n - 9, 9) = out.topRightCorner(9, n - 9).transpose();
  const Matrix9 corner = rows.leftCols(m) * t.motion.transpose();
  out.topLeftCorner<9, 9>() = (corner + corner.transpose()) / 2 + motion_noise(p, t);
  out.diagonal().tail(n - 9) += slow_noise(p, t).tail(n - 9);
  return out;
}

}  // namespace imulab::aided
