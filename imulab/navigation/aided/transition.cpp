#include "imulab/navigation/aided/transition.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/navigation/integration/increment.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace imulab::aided {
namespace {

using NineByThree = Eigen::Matrix<double, 9, 3>;

/// Returns the product column by column, because the general product of nine rows is slow.
NineByThree times(const NineByThree& by, const Matrix3d& m) {
  NineByThree out;
  for (Eigen::Index j = 0; j < 3; ++j) out.col(j) = m(0, j) * by.col(0) + m(1, j) * by.col(1) + m(2, j) * by.col(2);
  return out;
}
/// Returns by [w x].
NineByThree crossed(const NineByThree& by, const Vector3d& w) { return by.rowwise().cross(w.transpose()); }

/// The derivatives of the motion at the end by all errors at the start, from the last to the first step of several samples: 9 x 3 parts then suffice
/// for all elements of the sensors' matrices. Within a step, the Earth terms and the effect of a tilt change linearly: at 1 rad/s, the error is 4e-4
/// of the sensors' effects.
class ErrorGrowth {
 public:
  explicit ErrorGrowth(const Problem& problem) : p_(problem) {}

  /// Adds a sample; `C` is C_nb at its middle.
  void add(std::size_t number, const Matrix3d& C, const DelayedSample& delayed, const Increment& sample, const NavigationState& state,
           const LocalEarth& earth) {
    const TimedIncrement& raw = delayed.sample;
    constexpr double longest = 0.0501;  // s
    if (steps_.empty() || steps_.back().time + raw.interval > longest) {
      steps_.push_back({.turn = 2 * earth.rate + earth.transport_rate(state.velocity)});
      if (p_.terms) steps_.back().terms = Eigen::MatrixXd::Zero(6, p_.terms->sigma.size());
    }
    Step& s = steps_.back();
    s.time += raw.interval, s.pushed += C * sample.velocity, s.C += raw.interval * C;
    s.C_angle_slope += C * delayed.angle_slope;
    for (std::size_t j = 0; j < 3; ++j) {
      s.C_angle[j] += raw.increment.angle[static_cast<Eigen::Index>(j)] * C;
      s.C_velocity[j] += raw.increment.velocity[static_cast<Eigen::Index>(j)] * C;
    }
    if (!p_.terms) return;
    Eigen::Matrix<double, 6, Eigen::Dynamic> changes(6, s.terms.cols());
    p_.terms->at(p_.time[number], raw, changes);
    s.terms.topRows<3>() += raw.interval * C * changes.topRows<3>(), s.terms.bottomRows<3>() += raw.interval * C * changes.bottomRows<3>();
  }

  Transition finish(const LocalEarth& earth) const {
    Transition t;
    add_motion(earth, t);
    add_noise(t);
    t.decay = Eigen::VectorXd::Ones(p_.size), t.driven = Eigen::VectorXd::Zero(p_.size);
    for (const StateBlock& b : p_.blocks) {
      if (std::isfinite(b.time)) {
        const double a = std::exp(-t.interval / b.time);
        t.decay.segment(b.first, b.size).setConstant(a);
        t.driven.segment(b.first, b.size).setConstant(b.sigma * b.sigma * (1 - a * a));
      }
      if (b.walk.size() > 0) t.driven.segment(b.first, b.size) += t.interval * b.walk.cwiseAbs2();
    }
    return t;
  }

 private:
  /// Sums over several samples: of C_nb times their length, their readings, and the changes by each term.
  struct Step {
    Vector3d turn;  // at the begin
    double time = 0;
    Vector3d pushed = Vector3d::Zero(), C_angle_slope = pushed;
    Matrix3d C = Matrix3d::Zero();
    std::array<Matrix3d, 3> C_angle{C, C, C}, C_velocity{C, C, C};
    Eigen::Matrix<double, 6, Eigen::Dynamic> terms = {};
  };

  /// With w dt and f dt the sums of the sensors' errors rotated by C, a step is
  ///
  ///   u = -dt ((w_in x phi) + T dv) + dw dt,   phi <- phi + u,   r <- r + dt (dv before + dv after) / 2
  ///   dv <- dv - f x (phi + u / 2) - dt (2 w_ie + w_en) x dv + dg + df dt
  void add_motion(const LocalEarth& earth, Transition& t) const {
    NineByThree phi = NineByThree::Zero(), v = phi, r = phi;  // derivatives of the end by the state after the step
    phi.topRows<3>().setIdentity(), v.middleRows<3>(3).setIdentity(), r.bottomRows<3>().setIdentity();
    Matrix3d T = Matrix3d::Zero();  // derivative of the transport rate by the velocity
    T(0, 1) = -1 / earth.meridian_radius, T(1, 0) = 1 / earth.transverse_radius;
    T(2, 0) = earth.sin_latitude / earth.cos_latitude / earth.transverse_radius;
    const double gradient = -2 * earth.gravity.z() / earth.transverse_radius;
    t.motion.setZero(9, p_.sensors_end);
    const auto add = [&](Eigen::Index first, const NineByThree& by, const Matrix3d& change) {
      if (first >= 0) t.motion.middleCols<3>(first) += times(by, change);
    };
    for (auto s = steps_.rbegin(); s != steps_.rend(); ++s) {
      const double dt = s->time;
      const NineByThree by_v = v + dt / 2 * r, by_tilt = crossed(by_v, s->pushed), by_turn = phi - by_tilt / 2;
      add(p_.gyro_offset, by_turn, s->C), add(p_.accel_offset, by_v, s->C);
      add(p_.gyro_flicker, by_turn, s->C), add(p_.accel_flicker, by_v, s->C);
      add(p_.earth_rate, by_turn, -dt * Matrix3d::Identity());  // its part of the Coriolis acceleration is below 1.5e-4 m/s^2 at 1 m/s
      for (Eigen::Index j = 0; j < 3 && p_.gyro_matrix >= 0; ++j) {
        const auto at = static_cast<std::size_t>(j);
        add(p_.gyro_matrix + 3 * j, by_turn, s->C_angle[at]), add(p_.g_sensitivity + 3 * j, by_turn, s->C_velocity[at]);
        add(p_.accel_matrix + 3 * j, by_v, s->C_velocity[at]);
      }
      if (p_.gyro_delay >= 0) t.motion.col(p_.gyro_delay) += by_turn * s->C_angle_slope;
      if (p_.terms) t.motion.middleCols(p_.terms_first, s->terms.cols()) += by_turn * s->terms.topRows<3>() + by_v * s->terms.bottomRows<3>();
      phi -= by_tilt + dt * crossed(by_turn, s->turn - earth.rate);
      v = by_v + dt / 2 * r - dt * (crossed(by_v, s->turn) + times(by_turn, T));
      r.col(2) += dt * gradient * by_v.col(2);
    }
    t.motion.leftCols<9>() << phi, v, r;
  }

  /// Adds white noise of the rate under constant force over the interval: phi(t) is a random walk, v its integral times -[f x], r the integral of v.
  void add_noise(Transition& t) const {
    Vector3d pushed = Vector3d::Zero();
    Matrix3d C = Matrix3d::Zero();
    for (const Step& s : steps_) t.interval += s.time, pushed += s.pushed, C += s.C;
    C /= t.interval;
    const Matrix3d F = skew<double>(pushed);
    const Matrix3d gyro = C * p_.gyro_white.cwiseAbs2().asDiagonal() * C.transpose(),
                   accel = C * p_.accel_white.cwiseAbs2().asDiagonal() * C.transpose();
    const double T = t.interval;
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
};

}  // namespace

Integrated integrate(const Problem& p, std::size_t begin, std::size_t end, const FullState& start, bool with_transition,
                     std::vector<NavigationState>* each) {
  constexpr double served = 0.1;  // s, validity of the Earth at one place: the mean error of gravity is 1e-7 m/s^2 at 2 g
  const StrapdownOptions options{.gravity = p.gravity};
  NavigationState state = start.motion;
  ErrorGrowth growth(p);
  const auto with_rate = [&](LocalEarth earth) {
    if (p.earth_rate >= 0) earth.rate = start.x.segment<3>(p.earth_rate);
    return earth;
  };
  const LocalEarth first = with_rate(integration::earth_at(state.latitude, state.height, options));
  LocalEarth earth = first;
  Vector3d slow = integration::slow_acceleration(earth, state.velocity);
  double left = 0;  // s: remaining validity of that Earth
  std::optional<Increment> previous;
  if (begin > 0) previous = corrected(p, delayed_sample(p, begin - 1, start.x).sample, start.x);
  for (std::size_t i = begin; i < end; ++i) {
    const DelayedSample delayed = delayed_sample(p, i, start.x);
    const TimedIncrement& raw = delayed.sample;
    const Increment sample = corrected(p, raw, start.x);
    if (with_transition) {
      const Matrix3d C = state.q_nb.toRotationMatrix();
      growth.add(i, C + C * skew<double>(sample.angle / 2), delayed, sample, state, first);
    }
    if (left < raw.interval / 2)
      earth = with_rate(integration::earth_ahead(state, std::max(raw.interval, served) / 2, earth, options)), left = served;
    left -= raw.interval;
    const integration::BodyStep body = previous ? integration::body_step(sample, *previous) : integration::body_step({&sample, 1});
    integration::advance(state, body, raw.interval, earth, slow);
    previous = sample;
    if (each) each->push_back(state);
  }
  integration::expect_latitude(state.latitude);
  if (!with_transition) return {state, {}};
  Integrated out{state, growth.finish(first)};
  out.transition.motion_kind = motion_kind(start.motion, state, out.transition.interval);
  return out;
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

void decay_slow(const Transition& t, Eigen::MatrixXd& both) {
  for (Eigen::Index k = 9; k < t.decay.size(); ++k)
    if (t.decay[k] != 1) both.col(k) *= t.decay[k], both.row(k) *= t.decay[k];
}

Eigen::MatrixXd propagated(const Problem& p, const Transition& t, const Eigen::MatrixXd& P) {
  const Eigen::Index m = t.motion.cols();
  const NineRows rows = (P.leftCols(m) * t.motion.transpose()).transpose();  // P is symmetric
  Eigen::MatrixXd out = P;
  out.topRows<9>() = rows;
  out.leftCols<9>() = rows.transpose();
  decay_slow(t, out);
  const Matrix9 corner = rows.leftCols(m) * t.motion.transpose();
  out.topLeftCorner<9, 9>() = (corner + corner.transpose()) / 2 + motion_noise(p, t);
  out.diagonal().tail(p.size - 9) += slow_noise(p, t).tail(p.size - 9);
  return out;
}

}  // namespace imulab::aided
