#include "imulab/navigation/budget/noise_growth.hpp"

#include <cmath>
#include <utility>

namespace imulab::budget {

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

/// With u white, what is new in a process and in the integral of the sum is z_i: gain_i e^(-p_i s) u and I: (direct + sum gain_i (1 - e^(-p_i
/// s))/p_i) u, integrated over the time s to the end.
void NoiseGrowth::prepare(double T) {
  if (std::abs(T - interval_) < 1e-9 * T) return;
  interval_ = T;
  const auto& [pole, gain, direct, stationary] = processes_;
  const Eigen::Index n = pole.size();
  const auto decayed = [T](double p) { return p * T < 1e-12 ? T : -std::expm1(-p * T) / p; };  // integral of e^(-p s)
  const VectorXd slow = pole.cwiseMax(1e-4 / T);  // a process slower than that is a ramp in the interval, within 5e-5
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
  const VectorXd own_integral = own_ * integral_;  // covariance of a process and its noise's old part in the integral
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
