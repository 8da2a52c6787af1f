#include "imulab/estimate/noise/spectral_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

/// |H|^2 = 1 / (1 + (f / cutoff)^2n).
Share butterworth(double hz, double cutoff_hz, int order) {
  const double x = hz / cutoff_hz;
  double power = 1;
  for (int i = 0; i < order; ++i) power *= x * x;
  const double share = 1 / (1 + power);
  return {share, 2 * order * power * share * share};
}

/// (sin(n x) / (n sin x))^2: the mean of n readings.
double mean_of(std::size_t n, double x) {
  const double nn = static_cast<double>(n), sine = std::sin(x);
  return std::abs(sine) < 1e-12 ? 1 : std::pow(std::sin(nn * x) / (nn * sine), 2);
}

constexpr std::size_t most_folds = 16;

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

Passed passed(const SpectrumBin& bin, double cutoff_hz, int order) {
  const double hz = bin.middle_hz();
  const Share red = butterworth(hz, cutoff_hz, order);
  Passed out{red.value, red.by_log_cutoff, red.value, red.by_log_cutoff};
  if (bin.averaged == 1) return out;
  const double folding = 1 / bin.interval, reading = bin.interval / static_cast<double>(bin.averaged);
  double rest = 1;
  out.white = out.white_by_log_cutoff = 0;
  const auto add = [&](double f, double weight) {
    const Share share = butterworth(f, cutoff_hz, order);
    out.white += weight * share.value, out.white_by_log_cutoff += weight * share.by_log_cutoff;
    rest -= weight;
  };
  add(hz, mean_of(bin.averaged, pi * hz * reading));
  const std::size_t folds = std::min(most_folds, (bin.averaged - 1) / 2);
  for (std::size_t j = 1; j <= folds; ++j)
    for (const double f : {static_cast<double>(j) * folding - hz, static_cast<double>(j) * folding + hz})
      add(f, mean_of(bin.averaged, pi * f * reading));
  add((static_cast<double>(folds) + 1) * folding, rest);
  return out;
}

}  // namespace imulab::noise
