#include "imulab/estimate/noise/spectral_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace imulab::noise {

namespace {

using std::numbers::pi;

/// The ordinates of flicker have less power than its density says, because the transform mirrors the record at its ends: the integral of the density
/// times the squared Fourier transform of the cosine; 1 - 2 / (pi^2 k) from k = 4 on, within 0.1 %.
double mirrored_flicker(std::size_t k) {
  constexpr std::array<double, 4> first{0, 0.7737, 0.9028, 0.9311};
  return k < first.size() ? first[k] : 1 - 2 / (pi * pi * static_cast<double>(k));
}

struct Share {
  double value, by_log_cutoff;
};

/// |H|^2 = 1 / (1 + (f / cutoff)^2n), and bilinear: of the tangents of half the angles.
Share butterworth(double hz, double cutoff_hz, const LowPassShape& shape, double reading_s) {
  const double x = shape.digital ? std::tan(pi * hz * reading_s) / std::tan(pi * cutoff_hz * reading_s) : hz / cutoff_hz;
  // d ln x / d ln cutoff, less its sign
  const double falls = shape.digital ? 2 * pi * cutoff_hz * reading_s / std::sin(2 * pi * cutoff_hz * reading_s) : 1;
  double power = 1;
  for (int i = 0; i < shape.order; ++i) power *= x * x;
  const double share = 1 / (1 + power);
  return {share, 2 * shape.order * power * share * share * falls};
}

/// White noise that passed an analog filter, in readings: sampling folds what lies above half their rate.
Share sampled_white(double hz, double cutoff_hz, const LowPassShape& shape, double reading_s) {
  Share sum{0, 0}, at_zero{0, 0};
  for (int fold = -2; fold <= 2; ++fold) {
    const double f = fold / reading_s;
    const Share here = butterworth(std::abs(hz + f), cutoff_hz, shape, reading_s), there = butterworth(std::abs(f), cutoff_hz, shape, reading_s);
    sum.value += here.value, sum.by_log_cutoff += here.by_log_cutoff;
    at_zero.value += there.value, at_zero.by_log_cutoff += there.by_log_cutoff;
  }
  const double value = sum.value / at_zero.value;
  return {value, (sum.by_log_cutoff - value * at_zero.by_log_cutoff) / at_zero.value};
}

/// (sin(n x) / (n sin x))^2: the mean of n readings.
double mean_of(std::size_t n, double x) {
  const double nn = static_cast<double>(n), sine = std::sin(x);
  return std::abs(sine) < 1e-12 ? 1 : std::pow(std::sin(nn * x) / (nn * sine), 2);
}

constexpr std::size_t most_folds = 6;

}  // namespace

Densities unit_densities(const SpectrumBin& bin) {
  Densities mean;
  const std::size_t ordinates = bin.last - bin.first + 1, step = 1 + ordinates / 16;
  double count = 0;
  for (std::size_t k = bin.first + (ordinates - 1) % step / 2; k <= bin.last; k += step, ++count) {
    const double T = bin.interval, w = pi * static_cast<double>(k) / static_cast<double>(bin.length), sine = 2 * std::sin(w / 2);
    mean.Q += sine * sine / T;                                // differences of independent errors at the ends of each interval
    mean.K += T * T * (2 + std::cos(w)) / 3 / (sine * sine);  // means of a continuous walk
    for (int fold = -8; fold <= 8; ++fold) {                  // means of continuous flicker, folded by sampling
      const double x = std::abs(w / 2 + pi * fold), f = x / (pi * T);
      mean.B += mirrored_flicker(k) * std::pow(std::sin(x) / x, 2) / (2 * pi * f);
    }
  }
  for (double* const value : {&mean.Q, &mean.B, &mean.K}) *value /= count;
  return mean;
}

MarkovDensity markov_density(const SpectrumBin& bin, double time_s) {
  const double T = bin.interval, cosine = std::cos(2 * pi * bin.middle_hz() * T);
  // The covariances of means over T: g0, then g1 a^(k-1) at k intervals; their sum with cosines.
  const auto at = [&](double time) {
    const double x = T / time, a = std::exp(-x), lost = -std::expm1(-x);
    const double g0 = x > 1e-3 ? 2 * (x - lost) / (x * x) : 1 - x / 3 + x * x / 12, g1 = lost * lost / (x * x);
    return T * (g0 + 2 * g1 * (cosine - a) / (1 - 2 * a * cosine + a * a));
  };
  constexpr double step = 1e-3;
  return {at(time_s), (at(time_s * (1 + step)) - at(time_s * (1 - step))) / (2 * step)};
}

namespace {

Passed passed_at(const SpectrumBin& bin, double hz, double cutoff_hz, const LowPassShape& shape) {
  const double reading = bin.interval / static_cast<double>(bin.averaged);
  const Share red = butterworth(hz, cutoff_hz, shape, reading);
  Passed out{red.value, red.by_log_cutoff, red.value, red.by_log_cutoff};
  if (bin.averaged == 1) {
    if (shape.digital) return out;
    const Share white = sampled_white(hz, cutoff_hz, shape, reading);
    out.white = white.value, out.white_by_log_cutoff = white.by_log_cutoff;
    return out;
  }
  double rest = 1;
  out.white = out.white_by_log_cutoff = 0;
  const auto add = [&](double f, double weight) {
    const Share share = butterworth(std::min(f, 0.499 / reading), cutoff_hz, shape, reading);
    out.white += weight * share.value, out.white_by_log_cutoff += weight * share.by_log_cutoff;
    rest -= weight;
  };
  const double folding = 1 / bin.interval;
  add(hz, mean_of(bin.averaged, pi * hz * reading));
  const std::size_t folds = std::min(most_folds, (bin.averaged - 1) / 2);
  for (std::size_t j = 1; j <= folds; ++j)
    for (const double f : {static_cast<double>(j) * folding - hz, static_cast<double>(j) * folding + hz})
      add(f, mean_of(bin.averaged, pi * f * reading));
  add((static_cast<double>(folds) + 1) * folding, rest);
  return out;
}

}  // namespace

Passed passed(const SpectrumBin& bin, double cutoff_hz, const LowPassShape& shape) {
  const double middle = bin.middle_hz();
  if (middle < 0.1 * cutoff_hz) return passed_at(bin, middle, cutoff_hz, shape);
  // Simpson's rule over the bin: a filter of fourth order falls by a factor of 1.5 across one.
  Passed mean{0, 0, 0, 0};
  for (const auto& [hz, weight] : {std::pair{bin.low_hz(), 1.0 / 6}, std::pair{middle, 4.0 / 6}, std::pair{bin.high_hz(), 1.0 / 6}}) {
    const Passed at = passed_at(bin, std::min(hz, 0.4999 * static_cast<double>(bin.averaged) / bin.interval), cutoff_hz, shape);
    mean.red += weight * at.red, mean.red_by_log_cutoff += weight * at.red_by_log_cutoff;
    mean.white += weight * at.white, mean.white_by_log_cutoff += weight * at.white_by_log_cutoff;
  }
  return mean;
}

}  // namespace imulab::noise
