#include "imulab/estimate/noise/spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace imulab::noise {

namespace {

using std::numbers::pi;
constexpr std::size_t longest_transform = 65536, segment = 4096, finest_step = 64;
constexpr std::size_t single_ordinates = 32;
constexpr double bin_ratio = 1.05;  // of the frequencies of a bin

/// The largest number without prime factors above 5 that is at most n: their transforms are fast, and every n has one within a few percent.
std::size_t smooth_length(std::size_t n) {
  std::size_t best = 1;
  for (std::size_t a = 1; a <= n; a *= 5)
    for (std::size_t b = a; b <= n; b *= 3) {
      std::size_t c = b;
      while (2 * c <= n) c *= 2;
      best = std::max(best, c);
    }
  return best;
}

/// Orthonormal DCT-II by a Fourier transform of the same length (Makhoul 1980).
class CosineTransform {
 public:
  explicit CosineTransform(std::size_t n) : order_(n), spectrum_(n), turn_(n) {
    for (std::size_t k = 0; k < n; ++k)
      turn_[k] = std::polar(std::sqrt(2.0 / static_cast<double>(n)), -pi * static_cast<double>(k) / (2 * static_cast<double>(n)));
  }
  /// In place; ordinate 0 is not normalized.
  void operator()(std::vector<double>& y) {
    const std::size_t n = y.size();
    for (std::size_t j = 0; 2 * j < n; ++j) order_[j] = y[2 * j];
    for (std::size_t j = 0; 2 * j + 1 < n; ++j) order_[n - 1 - j] = y[2 * j + 1];
    fourier_.fwd(spectrum_, order_);
    for (std::size_t k = 0; k < n; ++k) y[k] = (spectrum_[k] * turn_[k]).real();
  }

 private:
  Eigen::FFT<double> fourier_;
  std::vector<std::complex<double>> order_, spectrum_, turn_;
};

/// Means of p readings from `begin`, less a line through the record's middle.
std::vector<double> means(std::span<const double> rate, std::size_t begin, std::size_t count, std::size_t p, double slope_per_sample) {
  std::vector<double> y(count);
  const double origin = rate[0];
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t at = begin + j * p;
    double sum = 0;
    for (std::size_t i = at; i < at + p; ++i) sum += rate[i] - origin;
    y[j] = sum / static_cast<double>(p) - slope_per_sample * (static_cast<double>(at) + 0.5 * static_cast<double>(p));
  }
  return y;
}

double slope_of(std::span<const double> rate) {
  const auto n = static_cast<double>(rate.size());
  double sum = 0, middle = 0.5 * (n - 1);
  for (std::size_t i = 0; i < rate.size(); ++i) sum += (static_cast<double>(i) - middle) * (rate[i] - rate[0]);
  return 12 * sum / (n * (n * n - 1));
}

/// Sums of squares of ordinates over all transforms of a level, binned.
void add_bins(Spectrum& spectrum, const std::vector<double>& squares, std::size_t first, std::size_t end, double interval, double transforms) {
  for (std::size_t k = first; k < end;) {
    const auto next = std::min(end, std::max(k + 1, static_cast<std::size_t>(std::floor(bin_ratio * static_cast<double>(k)))));
    SpectrumBin bin;
    bin.interval = interval;
    bin.length = squares.size();
    bin.first = k;
    bin.last = next - 1;
    bin.count = static_cast<double>(next - k) * transforms;
    for (std::size_t i = k; i < next; ++i) bin.power += squares[i];
    bin.power *= interval / bin.count;
    spectrum.bins.push_back(bin);
    k = next;
  }
}

/// The whole record in one transform: p samples averaged.
void add_record(Spectrum& spectrum, std::span<const double> rate, double interval_s, std::size_t p, std::size_t end, std::size_t n) {
  const double T = interval_s * static_cast<double>(p);
  CosineTransform transform(n);
  std::vector<double> y = means(rate, 0, n, p, spectrum.slope * interval_s), ramp(n);
  for (std::size_t j = 0; j < n; ++j) ramp[j] = T * static_cast<double>(j);
  transform(y);
  transform(ramp);
  std::vector<double> squares(n);
  for (std::size_t k = 0; k < n; ++k) squares[k] = y[k] * y[k];
  add_bins(spectrum, squares, 1, end, T, 1);
  for (SpectrumBin& bin : spectrum.bins)
    if (bin.first == bin.last && bin.first <= single_ordinates) {
      bin.amplitude = y[bin.first] * std::sqrt(T);
      bin.ramp = ramp[bin.first] * std::sqrt(T);
    }
}

/// Pieces of `segment` means of p samples, from the frequency on where the level before ended.
void add_segments(Spectrum& spectrum, std::span<const double> rate, double interval_s, std::size_t p, double from_hz) {
  const double T = interval_s * static_cast<double>(p);
  CosineTransform transform(segment);
  std::vector<double> squares(segment);
  double transforms = 0;
  for (std::size_t begin = 0; begin + p * segment <= rate.size(); begin += p * segment, ++transforms) {
    std::vector<double> y = means(rate, begin, segment, p, spectrum.slope * interval_s);
    transform(y);
    for (std::size_t k = 0; k < segment; ++k) squares[k] += y[k] * y[k];
  }
  const auto first = static_cast<std::size_t>(std::ceil(from_hz * 2 * T * static_cast<double>(segment)));
  add_bins(spectrum, squares, first, p == 1 ? segment : segment / 4, T, transforms);
}

/// The ordinates of flicker have less power than its density says, because the transform mirrors the record at its ends: the integral of the density
/// times the squared Fourier transform of the cosine; 1 - 2 / (pi^2 k) from k = 4 on, within 0.1 %.
double mirrored_flicker(std::size_t k) {
  constexpr std::array<double, 4> first{0, 0.7737, 0.9028, 0.9311};
  return k < first.size() ? first[k] : 1 - 2 / (pi * pi * static_cast<double>(k));
}

}  // namespace

Spectrum spectrum_of(std::span<const double> rate, double interval_s) {
  Spectrum spectrum;
  spectrum.slope = slope_of(rate) / interval_s;
  std::size_t p = (rate.size() + longest_transform - 1) / longest_transform;
  const std::size_t n = smooth_length(rate.size() / p);
  // Averaging attenuates and aliases the upper three quarters.
  add_record(spectrum, rate, interval_s, p, p == 1 ? n : n / 4, n);
  while (p > 1) {
    const double from_hz = spectrum.bins.back().high_hz();
    p = p > finest_step ? p / finest_step : 1;
    add_segments(spectrum, rate, interval_s, p, from_hz);
  }
  return spectrum;
}

Densities unit_densities(const SpectrumBin& bin) {
  Densities mean{0, 0, 0, 0};
  const std::size_t ordinates = bin.last - bin.first + 1, step = 1 + ordinates / 16;
  double count = 0;
  for (std::size_t k = bin.first + (ordinates - 1) % step / 2; k <= bin.last; k += step, ++count) {
    const double T = bin.interval, w = pi * static_cast<double>(k) / static_cast<double>(bin.length), sine = 2 * std::sin(w / 2);
    mean.N += 1;
    mean.Q += sine * sine / T;                                // differences of independent errors at the ends of each interval
    mean.K += T * T * (2 + std::cos(w)) / 3 / (sine * sine);  // means of a continuous walk
    for (int fold = -8; fold <= 8; ++fold) {                  // means of continuous flicker, folded by sampling
      const double x = std::abs(w / 2 + pi * fold), f = x / (pi * T);
      mean.B += mirrored_flicker(k) * std::pow(std::sin(x) / x, 2) / (2 * pi * f);
    }
  }
  for (double* const value : {&mean.Q, &mean.N, &mean.B, &mean.K}) *value /= count;
  return mean;
}

}  // namespace imulab::noise
