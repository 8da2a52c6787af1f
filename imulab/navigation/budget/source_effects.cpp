#include "imulab/navigation/budget/source_effects.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"

#include <cmath>
#include <utility>

namespace imulab::budget {
namespace {

/// Directions of an effect, by columns: an output axis, and the propagation of an accelerometer axis or raw reading axis through the model.
enum Direction { axis = 0, leak = 3, accel_reading = 6, accel_reading_leak = 9, gyro_reading = 12, direction_count = 15 };
/// Scalars of a sample: one, powers 1 to 3 of the raw readings V, the force, powers 1 to 3 of the thermal readings, powers 1 and 2 of them
/// times the output (row by row).
enum Scalar {
  one = 0,
  accel_power = 1,
  gyro_power = 10,
  force_component = 19,
  accel_thermal = 22,
  gyro_thermal = 31,
  accel_change = 40,
  gyro_change = 58,
  scalar_count = 76
};

bool ideal(const TriadModel& m) {
  return m.offset.isZero(0) && m.matrix.isIdentity(0) && m.quadratic.isZero(0) && m.cubic.isZero(0) && m.thermal.isZero(0) && !m.matrix_varies();
}

Matrix3d slope(const TriadModel& m, const Vector3d& v) {
  return m.matrix + Matrix3d((2 * m.quadratic.cwiseProduct(v) + 3 * m.cubic.cwiseProduct(v.cwiseAbs2())).asDiagonal());
}

/// The powers of thermal readings, and their products with the output.
void set_thermal(Eigen::Matrix<double, scalar_count, 1>& scalar, int power, int change, const Vector3d& tau, const Vector3d& out) {
  scalar.segment<9>(power) << tau, tau.cwiseAbs2(), tau.cwiseAbs2().cwiseProduct(tau);
  for (int row = 0; row < 3; ++row) {
    scalar.segment<3>(change + 3 * row) = tau[row] * out;
    scalar.segment<3>(change + 9 + 3 * row) = tau[row] * tau[row] * out;
  }
}

int scalar_of(const Coefficient& c) {
  const int power = c.triad == Triad::accel ? accel_power : gyro_power;
  switch (c.term) {
    case Term::offset:
      return one;
    case Term::matrix:
      return power + c.column;
    case Term::quadratic:
      return power + 3 + c.row;
    case Term::cubic:
      return power + 6 + c.row;
    case Term::thermal:
      return (c.triad == Triad::accel ? accel_thermal : gyro_thermal) + 3 * (c.column - 1) + c.row;
    case Term::matrix_thermal1:
    case Term::matrix_thermal2:
      return (c.triad == Triad::accel ? accel_change : gyro_change) + (c.term == Term::matrix_thermal1 ? 0 : 9) + 3 * c.row + c.column;
    case Term::g_sensitivity:
      return force_component + c.column;
    case Term::lever_arm:
      break;
  }
  throw Error(std::string(c.name) + ": the compensation of single samples has no lever arms: their errors cannot be followed");
}

}  // namespace

CoefficientEffects::CoefficientEffects(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Vector3d& accel_tau,
                                       const Vector3d& gyro_tau)
    : model_(model), plain_(ideal(model.accel) && ideal(model.gyro) && model.g_sensitivity.isZero(0)), accel_tau_(accel_tau), gyro_tau_(gyro_tau) {
  const bool leaks = !model.g_sensitivity.isZero(0);
  const auto n = static_cast<Eigen::Index>(coefficients.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const Coefficient& c = coefficient(coefficients[static_cast<std::size_t>(k)]);
    const bool thermal = c.term == Term::thermal;
    const int scalar = scalar_of(c);
    if (c.triad == Triad::gyro) rate_effects_.push_back({k, scalar, (thermal ? gyro_reading : axis) + c.row});
    if (c.triad == Triad::accel) force_effects_.push_back({k, scalar, (thermal ? accel_reading : axis) + c.row});
    if (c.triad == Triad::accel && leaks) rate_effects_.push_back({k, scalar, (thermal ? accel_reading_leak : leak) + c.row});
  }
  rate_.setZero(3, n);
  force_.setZero(3, n);
}

void CoefficientEffects::clear() {
  rate_.setZero();
  force_.setZero();
}

void CoefficientEffects::add(const Matrix3d& C_nb, const Motion& motion, double interval) {
  Eigen::Matrix<double, 3, direction_count> direction;
  Eigen::Matrix<double, scalar_count, 1> scalar;
  direction.middleCols<3>(axis) = C_nb;
  const RawSample raw = plain_ ? RawSample{.gyro = motion.rate, .accel = motion.force} : decompensate(model_, motion, gyro_tau_, accel_tau_);
  const Vector3d a = raw.accel - model_.accel.drift(accel_tau_), w = raw.gyro - model_.gyro.drift(gyro_tau_);
  const Vector3d rate = motion.rate - model_.g_sensitivity * motion.force;
  if (!plain_) {
    direction.middleCols<3>(leak) = C_nb * model_.g_sensitivity;
    direction.middleCols<3>(accel_reading) = -C_nb * slope(model_.accel, a);
    direction.middleCols<3>(accel_reading_leak) = -direction.middleCols<3>(leak) * slope(model_.accel, a);
    direction.middleCols<3>(gyro_reading) = -C_nb * slope(model_.gyro, w);
  } else {
    direction.middleCols<3>(accel_reading) = direction.middleCols<3>(gyro_reading) = -C_nb;
  }
  scalar[one] = 1;
  scalar.segment<9>(accel_power) << a, a.cwiseAbs2(), a.cwiseAbs2().cwiseProduct(a);
  scalar.segment<9>(gyro_power) << w, w.cwiseAbs2(), w.cwiseAbs2().cwiseProduct(w);
  scalar.segment<3>(force_component) = motion.force;
  set_thermal(scalar, accel_thermal, accel_change, accel_tau_, motion.force);
  set_thermal(scalar, gyro_thermal, gyro_change, gyro_tau_, rate);
  scalar *= interval;
  for (const Effect& e : rate_effects_) rate_.col(e.coefficient) += scalar[e.scalar] * direction.col(e.direction);
  for (const Effect& e : force_effects_) force_.col(e.coefficient) += scalar[e.scalar] * direction.col(e.direction);
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

NoiseProcesses white_noise(double density) { return {{}, {}, density, false}; }

NoiseProcesses random_walk(double K) { return {VectorXd::Zero(1), VectorXd::Constant(1, K), 0, false}; }

NoiseProcesses flicker_noise(double B, double interval) {
  const Flicker flicker(B, interval);
  return {flicker.pole, flicker.gain, flicker.direct, true};
}

NoiseProcesses markov_noise(double sigma, double time_constant) {
  return {VectorXd::Constant(1, 1 / time_constant), VectorXd::Constant(1, sigma * std::sqrt(2 / time_constant)), 0, true};
}

NoiseGrowth::NoiseGrowth(NoiseProcesses processes, int noises) : processes_(std::move(processes)) {
  const Eigen::Index n = processes_.pole.size();
  own_.setZero(n, n);
  if (processes_.stationary)
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) own_(i, j) = processes_.gain[i] * processes_.gain[j] / (processes_.pole[i] + processes_.pole[j]);
  cross_.assign(static_cast<std::size_t>(noises), ErrorColumns::Zero(ErrorIndex::count, n));
}

/// For white u, the new part of a process is z_i: gain_i e^(-p_i s) u, and of the integral of the sum I: (direct + sum gain_i (1 - e^(-p_i s))/p_i)
/// u, integrated over the time s to the end.
void NoiseGrowth::prepare(double T) {
  if (std::abs(T - interval_) < 1e-9 * T) return;
  interval_ = T;
  const auto& [pole, gain, direct, stationary] = processes_;
  const Eigen::Index n = pole.size();
  const auto decayed = [T](double p) { return p * T < 1e-12 ? T : -std::expm1(-p * T) / p; };  // integral of e^(-p s)
  const VectorXd slow = pole.cwiseMax(1e-4 / T);  // a slower process is a ramp in the interval, within 5e-5
  decay_ = (-T * pole.array()).exp();
  integral_ = pole.unaryExpr(decayed);
  new_.resize(n, n);
  new_with_integral_ = direct * gain.cwiseProduct(integral_);
  new_integral_ = direct * direct * T;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double p = slow[i];
    new_integral_ += 2 * direct * gain[i] * (T - decayed(p)) / p;
    for (Eigen::Index j = 0; j < n; ++j) {
      const double both = gain[i] * gain[j], q = slow[j];
      new_(i, j) = both * decayed(pole[i] + pole[j]);
      new_with_integral_[j] += both / p * (decayed(q) - decayed(p + q));
      new_integral_ += both / (p * q) * (T - decayed(p) - decayed(q) + decayed(p + q));
    }
  }
}

void NoiseGrowth::step(const ErrorMatrix& transition, const ErrorColumns& effect, double interval) {
  prepare(interval);
  const VectorXd own_integral = own_ * integral_;  // covariance of a process and the old part of its noise in the integral
  const double variance = integral_.dot(own_integral) + new_integral_;
  covariance_ = (transition * covariance_ * transition.transpose()).eval();
  for (std::size_t k = 0; k < cross_.size(); ++k) {
    const ErrorState g = effect.col(static_cast<Eigen::Index>(k)) / interval;
    const ErrorMatrix mixed = transition * (cross_[k] * integral_) * g.transpose();
    covariance_ += mixed + mixed.transpose() + variance * g * g.transpose();
    cross_[k] = ((transition * cross_[k] + g * own_integral.transpose()) * decay_.asDiagonal() + g * new_with_integral_.transpose()).eval();
  }
  own_ = (decay_.asDiagonal() * own_ * decay_.asDiagonal() + new_).eval();
}

}  // namespace imulab::budget
