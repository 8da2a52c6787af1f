#include "imulab/model/sensor_noise.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

constexpr std::size_t chunk = 512;  // draws at once
/// Weights of the last draws, the newest first, as fractions of B: the power of means over a sample's interval that the processes of the flicker
/// lack. Fitted to B^2 / (2 pi f) with the sinc^2 of means, folded by sampling: within 1.7 % at all frequencies, instead of 28 %.
constexpr std::array<double, 4> flicker_rest{0.080514, -0.012116, -0.018247, -0.006552};
constexpr std::size_t past = flicker_rest.size() - 1;
using Draws = std::array<double, past + chunk>;

double constant(const Spread& spread, std::uint64_t seed, const std::string& purpose) {
  return spread.fixed ? spread.value : spread.value * RandomStream(seed, purpose).normal(0);
}

}  // namespace

AxisNoise::AxisNoise(const NoiseModel& model, double interval_s, std::uint64_t seed, const std::string& purpose)
    : model_(model),
      interval_s_(interval_s),
      bias_(constant(model.turn_on, seed, "turn-on of " + purpose)),
      ramp_(constant(model.R, seed, "ramp of " + purpose)),
      white_(seed, purpose),
      quantization_(seed, "quantisation of " + purpose),
      flicker_(seed, "flicker of " + purpose),
      walk_(seed, "walk of " + purpose),
      start_(seed, "flicker's start of " + purpose) {
  const Flicker flicker(model.B, interval_s);  // its white noise is constant in a sample
  for (int m = 0; m < Flicker::processes; ++m) {
    const double pole = flicker.pole(m);
    decay_(m) = std::exp(-pole * interval_s);
    driven_(m) = flicker.gain(m) * (-std::expm1(-pole * interval_s) / pole) / std::sqrt(interval_s);
  }
  for (std::size_t i = 0; i < flicker_rest.size(); ++i) direct_[i] = model.B * flicker_rest[i];
  direct_[0] += flicker.direct / std::sqrt(interval_s);
}

bool AxisNoise::slow() const { return bias_ != 0 || ramp_ != 0 || model_.B != 0 || model_.K != 0; }

Flicker::Array AxisNoise::stationary_draw() const {
  Eigen::Matrix<double, Flicker::processes, Flicker::processes> covariance;  // covariance of processes with one driver
  for (int i = 0; i < Flicker::processes; ++i)
    for (int j = 0; j < Flicker::processes; ++j) covariance(i, j) = driven_(i) * driven_(j) / (1 - decay_(i) * decay_(j));
  Eigen::Matrix<double, Flicker::processes, 1> z;
  start_.normals(0, {z.data(), static_cast<std::size_t>(Flicker::processes)});
  return (covariance.llt().matrixL() * z).array();
}

void AxisNoise::add_slow(std::span<double> recording) const {
  Flicker::Array state = model_.B != 0 ? stationary_draw() : Flicker::Array::Zero();
  double sum = state.sum(), walk = 0;
  const double walk_step = model_.K * std::sqrt(interval_s_);
  Draws draws;
  const std::span<double> last = std::span(draws).first(past);
  start_.normals(Flicker::processes, last);
  for (std::size_t begin = 0; begin < recording.size(); begin += chunk) {
    const std::span<double> out = recording.subspan(begin, std::min(chunk, recording.size() - begin));
    const std::span<double> drawn = std::span(draws).subspan(past, out.size());
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += bias_ + ramp_ * interval_s_ * (static_cast<double>(begin + k) + 0.5);
    if (model_.B != 0) {
      flicker_.normals(begin, drawn);
      for (std::size_t k = 0; k < out.size(); ++k) {
        state = decay_ * state + driven_ * drawn[k];
        const double before = sum;
        sum = state.sum();
        const double* const z = &draws[past + k];
        out[k] += 0.5 * (before + sum) + direct_[0] * z[0] + direct_[1] * z[-1] + direct_[2] * z[-2] + direct_[3] * z[-3];
      }
      std::copy(drawn.end() - static_cast<std::ptrdiff_t>(std::min(past, drawn.size())), drawn.end(), last.begin());
    }
    if (model_.K != 0) {
      walk_.normals(begin, drawn);
      for (std::size_t k = 0; k < out.size(); ++k) {
        const double step = walk_step * drawn[k];
        out[k] += walk + 0.5 * step;
        walk += step;
      }
    }
  }
}

void AxisNoise::add_fast(std::size_t begin, std::span<double> out) const {
  std::array<double, chunk + 1> draws;
  const double white = model_.N / std::sqrt(interval_s_), quantum = model_.Q / interval_s_;
  for (std::size_t done = 0; done < out.size(); done += chunk) {
    const std::size_t n = std::min(chunk, out.size() - done);
    if (model_.N != 0) {
      white_.normals(begin + done, std::span(draws).first(n));
      for (std::size_t k = 0; k < n; ++k) out[done + k] += white * draws[k];
    }
    if (model_.Q != 0) {  // error of the integral at the end of the sample minus that at its beginning
      quantization_.normals(begin + done, std::span(draws).first(n + 1));
      for (std::size_t k = 0; k < n; ++k) out[done + k] += quantum * (draws[k + 1] - draws[k]);
    }
  }
}

}  // namespace imulab
