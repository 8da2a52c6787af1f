#include "imulab/navigation/aided/transition.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace imulab::aided {
namespace {

using NineByThree = Eigen::Matrix<double, 9, 3>;

/// The derivatives of the motion at the end by all errors at the start, sample by sample from the last to the first: 9 x 3 parts then do for all
/// elements of the sensors' matrices.
class ErrorGrowth {
 public:
  ErrorGrowth(const Problem& problem, std::size_t samples) : p_(problem) { steps_.reserve(samples); }

  /// `C`: C_nb at the sample's middle.
  void add(std::size_t number, const Matrix3d& C, const TimedIncrement& raw, const Increment& sample, const NavigationState& state,
           const LocalEarth& earth) {
    const double dt = raw.interval;
    const Vector3d pushed = C * sample.velocity, turn = 2 * earth.rate + earth.transport_rate(state.velocity);
    steps_.push_back({number, C, raw, pushed, turn});
    pushed_ += pushed, interval_ += dt, mean_C_ += dt * C;
  }

  Transition finish(const LocalEarth& earth) const {
    Transition t;
    add_motion(earth, t);
    t.interval = interval_;
    add_noise(t);
    t.decay = Eigen::VectorXd::Ones(p_.size), t.driven = Eigen::VectorXd::Zero(p_.size);
    for (const StateBlock& b : p_.blocks) {
      if (std::isfinite(b.time)) {
        const double a = std::exp(-interval_ / b.time);
        t.decay.segment(b.first, b.size).setConstant(a);
        t.driven.segment(b.first, b.size).setConstant(b.sigma * b.sigma * (1 - a * a));
      }
      if (b.walk.size() > 0) t.driven.segment(b.first, b.size) += interval_ * b.walk.cwiseAbs2();
    }
    return t;
  }

 private:
  struct Step {
    std::size_t number;  // of the sample
    Matrix3d C;
    TimedIncrement raw;
    Vector3d pushed, turn;
  };

  /// A sample's own step is
  ///
  ///   u = -dt ((w_in x phi) + T dv) + C dw,   phi <- phi + u,   r <- r + dt (dv before + dv after) / 2
  ///   dv <- dv - f x (phi + u / 2) - dt (2 w_ie + w_en) x dv + dg + C df
  void add_motion(const LocalEarth& earth, Transition& t) const {
    NineByThree phi = NineByThree::Zero(), v = phi, r = phi;  // of the end by the state after the sample
    phi.topRows<3>().setIdentity(), v.middleRows<3>(3).setIdentity(), r.bottomRows<3>().setIdentity();
    Matrix3d T = Matrix3d::Zero();  // of the transport rate by the velocity
    T(0, 1) = -1 / earth.meridian_radius, T(1, 0) = 1 / earth.transverse_radius;
    T(2, 0) = earth.sin_latitude / earth.cos_latitude / earth.transverse_radius;
    const double gradient = -2 * earth.gravity.z() / earth.transverse_radius;
    std::array<NineByThree, 7> gyro;   // offset, matrix by column, g-sensitivity by column
    std::array<NineByThree, 4> accel;  // offset, matrix by column
    gyro.fill(NineByThree::Zero()), accel.fill(NineByThree::Zero());
    Eigen::Matrix<double, 6, Eigen::Dynamic> changes(6, p_.terms ? p_.terms->sigma.size() : 0);
    NineRows terms = NineRows::Zero(9, changes.cols());
    for (auto s = steps_.rbegin(); s != steps_.rend(); ++s) {
      const double dt = s->raw.interval;
      const Vector3d &angle = s->raw.increment.angle, &velocity = s->raw.increment.velocity;
      const NineByThree by_v = v + dt / 2 * r, by_tilt = by_v * skew<double>(s->pushed), by_turn = phi - by_tilt / 2;
      const NineByThree by_gyro = by_turn * s->C, by_accel = by_v * s->C;
      gyro[0] += dt * by_gyro, accel[0] += dt * by_accel;
      if (p_.terms) {
        p_.terms->at(p_.time[s->number], s->raw, changes);
        terms += dt * by_gyro * changes.topRows<3>() + dt * by_accel * changes.bottomRows<3>();
      }
      for (Eigen::Index j = 0; j < 3 && p_.sensors_end > p_.accel_offset + 3; ++j) {
        const auto at = static_cast<std::size_t>(j);
        gyro[1 + at] += angle[j] * by_gyro, gyro[4 + at] += velocity[j] * by_gyro, accel[1 + at] += velocity[j] * by_accel;
      }
      phi -= by_tilt + dt * (by_turn * skew<double>(s->turn - earth.rate));
      v = by_v + dt / 2 * r - dt * (by_v * skew<double>(s->turn) + by_turn * T);
      r.col(2) += dt * gradient * by_v.col(2);
    }
    t.motion.setZero(9, p_.sensors_end);
    t.motion.leftCols<9>() << phi, v, r;
    const auto place = [&](Eigen::Index first, const NineByThree* parts, Eigen::Index count) {
      for (Eigen::Index k = 0; first >= 0 && k < count; ++k) t.motion.middleCols<3>(first + 3 * k) = parts[k];
    };
    place(p_.gyro_offset, gyro.data(), 1), place(p_.gyro_matrix, gyro.data() + 1, 3), place(p_.g_sensitivity, gyro.data() + 4, 3);
    if (p_.terms) t.motion.middleCols(p_.terms_first, terms.cols()) = terms;
    place(p_.accel_offset, accel.data(), 1), place(p_.accel_matrix, accel.data() + 1, 3);
  }

  /// White noise of the rate with the force constant over the interval: phi(t) is a walk, v its integral times -[f x], r that of v.
  void add_noise(Transition& t) const {
    const Matrix3d C = mean_C_ / interval_, F = skew<double>(pushed_);
    const Matrix3d gyro = C * p_.gyro_noise.cwiseAbs2().asDiagonal() * C.transpose(),
                   accel = C * p_.accel_noise.cwiseAbs2().asDiagonal() * C.transpose();
    const double T = interval_;
    const auto block = [](Matrix9& Q, Eigen::Index i, Eigen::Index j, const Matrix3d& value) {
      Q.block<3, 3>(i, j) = value;
      Q.block<3, 3>(j, i) = value.transpose();
    };
    block(t.gyro, 0, 0, T * gyro), block(t.gyro, 3, 0, -T / 2 * F * gyro), block(t.gyro, 6, 0, -T * T / 6 * F * gyro);
    const Matrix3d FgF = F * gyro * F.transpose();
    block(t.gyro, 3, 3, T / 3 * FgF), block(t.gyro, 6, 3, T * T / 8 * FgF), block(t.gyro, 6, 6, T * T * T / 20 * FgF);
    block(t.accel, 3, 3, T * accel), block(t.accel, 6, 3, T * T / 2 * accel), block(t.accel, 6, 6, T * T * T / 3 * accel);
  }

  const Problem& p_;
  std::vector<Step> steps_;
  Vector3d pushed_ = Vector3d::Zero();
  Matrix3d mean_C_ = Matrix3d::Zero();
  double interval_ = 0;
};

}  // namespace

Integrated integrate(const Problem& p, std::size_t begin, std::size_t end, const FullState& start, bool with_transition,
                     std::vector<NavigationState>* each) {
  const StrapdownOptions options{.gravity = p.gravity};
  Strapdown strapdown(start.motion, options);
  ErrorGrowth growth(p, with_transition ? end - begin : 0);
  LocalEarth earth = integration::earth_at(start.motion.latitude, start.motion.height, options);
  for (std::size_t i = begin; i < end; ++i) {
    const TimedIncrement raw = p.samples[i];
    const Increment sample = corrected(p, raw, start.x);
    if (with_transition) {
      const Matrix3d C = strapdown.state().q_nb.toRotationMatrix();
      growth.add(i, C + C * skew<double>(sample.angle / 2), raw, sample, strapdown.state(), earth);
    }
    strapdown.step(sample, raw.interval);
    if (each) each->push_back(strapdown.state());
  }
  return {strapdown.state(), with_transition ? growth.finish(earth) : Transition{}};
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
  return propagated(p, t, P, t.motion * P.topRows(t.motion.cols()));
}

Eigen::MatrixXd propagated(const Problem& p, const Transition& t, const Eigen::MatrixXd& P, const NineRows& rows) {
  const Eigen::Index n = p.size, m = t.motion.cols();
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
