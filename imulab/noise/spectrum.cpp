#include "imulab/noise/spectrum.hpp"

#include "imulab/error.hpp"

#include <Eigen/LU>
#include <fmt/core.h>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>

namespace imulab::noise {

namespace {

using std::numbers::pi;
constexpr std::size_t longest_transform = 65536, finest_step = 64;
constexpr std::size_t shortest_piece = 4096, longest_piece = 32768, fewest_pieces = 16;
constexpr std::size_t single_ordinates = 32;
constexpr std::size_t widest_bin = 64;  // ordinates: near half the rate a filter may fall steeply
constexpr double bin_ratio = 1.05;      // ratio of the frequencies of a bin
constexpr double beside = 2.5;          // ordinates left out around a sinusoid
constexpr double fewest_periods = 1.5;  // periods of a sinusoid in the readings of a transform; fewer hardly separate it from a ramp

/// Returns the largest number up to n without prime factors above 5: such transforms are fast, and there is one within a few percent of every n.
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
  /// Transforms in place; ordinate 0 is not normalized.
  void operator()(std::vector<double>& y) {
    const std::size_t n = y.size();
    for (std::size_t j = 0; 2 * j < n; ++j) order_[j] = y[2 * j];
    for (std::size_t j = 0; 2 * j + 1 < n; ++j) order_[n - 1 - j] = y[2 * j + 1];
    fourier_.fwd(spectrum_, order_);
    for (std::size_t k = 0; k < n; ++k) y[k] = (spectrum_[k] * turn_[k]).real();
  }

 private:
  Eigen::FFT<double> fourier_;
  std::vector<double> order_;
  std::vector<std::complex<double>> spectrum_, turn_;
};

/// Returns means of p readings from `begin`, minus a line through the middle of the record.
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

/// A sinusoid and a mean, fitted to y by least squares.
struct Sinusoid {
  double mean, cosine, sine;
  double square() const { return cosine * cosine + sine * sine; }
};

using Readings = Eigen::Map<const Eigen::ArrayXd>;

/// Calls `each`(first, cosines, sines) for blocks of j from 0 to n, with cos(w j) and sin(w j): the first block is rotated to each block.
template <class Each>
void along(double w, std::size_t n, Each each) {
  constexpr Eigen::Index block = 256;
  using Block = Eigen::Array<double, block, 1>;
  const Block angle = Block::LinSpaced(0, static_cast<double>(block - 1)) * w, cosine = angle.cos(), sine = angle.sin();
  const auto end = static_cast<Eigen::Index>(n);
  for (Eigen::Index first = 0; first < end; first += block) {
    const Eigen::Index count = std::min(block, end - first);
    const double at = w * static_cast<double>(first), c = std::cos(at), s = std::sin(at);
    const Block cosines = c * cosine - s * sine, sines = s * cosine + c * sine;
    each(first, cosines.head(count), sines.head(count));
  }
}

Sinusoid fit_sinusoid(const std::vector<double>& y, double w) {
  const Readings readings(y.data(), static_cast<Eigen::Index>(y.size()));
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  along(w, y.size(), [&](Eigen::Index first, const auto& c, const auto& s) {
    const auto part = readings.segment(first, c.size());
    normal(0, 1) += c.sum(), normal(0, 2) += s.sum(), normal(1, 1) += c.square().sum(), normal(1, 2) += (c * s).sum(),
        normal(2, 2) += s.square().sum();
    right += Eigen::Vector3d(part.sum(), (part * c).sum(), (part * s).sum());
  });
  normal(0, 0) = static_cast<double>(y.size());
  normal(1, 0) = normal(0, 1), normal(2, 0) = normal(0, 2), normal(2, 1) = normal(1, 2);
  const Eigen::Vector3d x = normal.inverse() * right;
  return {x[0], x[1], x[2]};
}

void subtract(std::vector<double>& y, const Sinusoid& fitted, double w) {
  Eigen::Map<Eigen::ArrayXd> readings(y.data(), static_cast<Eigen::Index>(y.size()));
  along(w, y.size(),
        [&](Eigen::Index first, const auto& c, const auto& s) { readings.segment(first, c.size()) -= fitted.cosine * c + fitted.sine * s; });
}

/// Returns the frequency after folding by sampling at this interval, in radians per sample, 0 to pi.
double folded(double hz, double interval) {
  const double turns = hz * interval;
  return 2 * pi * std::abs(turns - std::round(turns));
}

bool tells(double hz, double interval, std::size_t length) {
  const double w = folded(hz, interval), periods = w / (2 * pi) * static_cast<double>(length);
  return periods >= fewest_periods && static_cast<double>(length) / 2 - periods >= 0.5 * fewest_periods;
}

/// Removes the sinusoids; the squared amplitude of the last one is added to that of the spectrum.
void remove_sinusoids(Spectrum& spectrum, std::vector<double>& y, double interval, const std::vector<double>& without) {
  for (const double& hz : without) {
    if (!tells(hz, interval, y.size())) continue;
    const double w = folded(hz, interval);
    const Sinusoid fitted = fit_sinusoid(y, w);
    subtract(y, fitted, w);
    if (&hz != &without.back() || hz * interval >= 0.5) continue;
    const double piece_s = interval * static_cast<double>(y.size());
    if (piece_s != spectrum.piece_s) spectrum.squares = spectrum.pieces = 0, spectrum.piece_s = piece_s;
    spectrum.squares += fitted.square(), ++spectrum.pieces;
  }
}

bool is_beside(const SpectrumLevel& level, std::size_t k, const std::vector<double>& without) {
  return std::any_of(without.begin(), without.end(), [&](double hz) {
    return tells(hz, level.interval, level.power.size()) &&
           std::abs(folded(hz, level.interval) / pi * static_cast<double>(level.power.size()) - static_cast<double>(k)) <= beside;
  });
}

/// Combines successive ordinates of a level, except those next to a sinusoid.
void add_bins(Spectrum& spectrum, const SpectrumLevel& level, const std::vector<double>& without) {
  for (std::size_t k = level.first; k < level.end;) {
    if (is_beside(level, k, without)) {
      ++k;
      continue;
    }
    const auto wide = static_cast<std::size_t>(std::floor(bin_ratio * static_cast<double>(k)));
    const auto widest = std::min({level.end, std::max(k + 1, wide), k + std::max<std::size_t>(widest_bin, level.power.size() / 64)});
    SpectrumBin bin;
    bin.interval = level.interval;
    bin.averaged = level.averaged;
    bin.length = level.power.size();
    bin.first = k;
    for (; k < widest && !is_beside(level, k, without); ++k) bin.power += level.power[k];
    bin.last = k - 1;
    bin.power /= static_cast<double>(k - bin.first);
    bin.count = static_cast<double>(k - bin.first) * level.transforms;
    spectrum.bins.push_back(bin);
  }
}

/// Adds the whole record in one transform with p samples averaged.
void add_record(Spectrum& spectrum, std::span<const double> rate, double interval_s, std::size_t p, const std::vector<double>& without) {
  const std::size_t n = smooth_length(rate.size() / p);
  const double T = interval_s * static_cast<double>(p);
  CosineTransform transform(n);
  std::vector<double> y = means(rate, 0, n, p, spectrum.slope * interval_s), ramp(n);
  for (std::size_t j = 0; j < n; ++j) ramp[j] = T * static_cast<double>(j);
  remove_sinusoids(spectrum, y, T, without);
  transform(y);
  transform(ramp);
  // Averaging attenuates and aliases the upper three quarters.
  SpectrumLevel level{T, p, 1, p == 1 ? n : n / 4, 1, y};
  for (double& ordinate : level.power) ordinate *= ordinate * T;
  add_bins(spectrum, level, without);
  for (SpectrumBin& bin : spectrum.bins)
    if (bin.first == bin.last && bin.first <= single_ordinates) {
      bin.amplitude = y[bin.first] * std::sqrt(T);
      bin.ramp = ramp[bin.first] * std::sqrt(T);
    }
  spectrum.levels.push_back(std::move(level));
}

/// Returns the length of a piece: leakage from strong to weak frequencies falls with it.
std::size_t piece_of(std::size_t means) {
  std::size_t length = shortest_piece;
  while (2 * length <= longest_piece && 2 * length * fewest_pieces <= means) length *= 2;
  return length;
}

/// Adds pieces of means of p samples, from the frequency at which the previous level ended.
void add_segments(Spectrum& spectrum, std::span<const double> rate, double interval_s, std::size_t p, double from_hz,
                  const std::vector<double>& without) {
  const double T = interval_s * static_cast<double>(p);
  const std::size_t segment = piece_of(rate.size() / p);
  CosineTransform transform(segment);
  const auto first = static_cast<std::size_t>(std::ceil(from_hz * 2 * T * static_cast<double>(segment)));
  SpectrumLevel level{T, p, first, p == 1 ? segment : segment / 4, 0, std::vector<double>(segment)};
  for (std::size_t begin = 0; begin + p * segment <= rate.size(); begin += p * segment, ++level.transforms) {
    std::vector<double> y = means(rate, begin, segment, p, spectrum.slope * interval_s);
    remove_sinusoids(spectrum, y, T, without);
    transform(y);
    for (std::size_t k = 0; k < segment; ++k) level.power[k] += y[k] * y[k];
  }
  for (double& power : level.power) power *= T / level.transforms;
  add_bins(spectrum, level, without);
  spectrum.levels.push_back(std::move(level));
}

}  // namespace

Spectrum spectrum_of(std::span<const double> rate, double interval_s, const std::vector<double>& without) {
  Spectrum spectrum;
  spectrum.slope = slope_of(rate) / interval_s;
  spectrum.record_s = interval_s * static_cast<double>(rate.size());
  std::size_t p = (rate.size() + longest_transform - 1) / longest_transform;
  add_record(spectrum, rate, interval_s, p, without);
  while (p > 1) {
    const double from_hz = spectrum.levels.back().hz(static_cast<double>(spectrum.levels.back().end) - 0.5);
    p = p > finest_step ? p / finest_step : 1;
    add_segments(spectrum, rate, interval_s, p, from_hz, without);
  }
  return spectrum;
}

double sharpened(std::span<const double> rate, double interval_s, double hz, double piece_s) {
  const auto averaged = std::max<std::size_t>(1, static_cast<std::size_t>(0.1 / (hz * interval_s)));  // ten per period
  const double T = interval_s * static_cast<double>(averaged);
  const auto length = std::min(static_cast<std::size_t>(piece_s / T), rate.size() / averaged);
  constexpr std::size_t most_pieces = 8;
  const std::size_t pieces = std::clamp<std::size_t>(rate.size() / (length * averaged), 1, most_pieces);
  std::vector<std::vector<double>> parts;
  for (std::size_t i = 0; i < pieces; ++i) parts.push_back(means(rate, i * length * averaged, length, averaged, slope_of(rate)));
  const auto taken = [&](double f) {
    double sum = 0;
    for (const std::vector<double>& part : parts) sum += fit_sinusoid(part, folded(f, T)).square();
    return sum;
  };
  // The width of the peak is about one over the length of a piece: search a grid of eighths, then by thirds.
  const double width = 1 / (T * static_cast<double>(length));
  double best = hz, most = taken(hz);
  for (int i = -8; i <= 8; ++i)
    if (const double f = hz + width * i / 8, value = taken(f); value > most) best = f, most = value;
  double low = best - width / 8, high = best + width / 8;
  while (high - low > 1e-3 * width) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (taken(a) > taken(b))
      high = b;
    else
      low = a;
  }
  return 0.5 * (low + high);
}

}  // namespace imulab::noise

namespace imulab {

WelchSpectrum welch_spectrum(std::span<const double> rate, double interval_s, std::size_t length) {
  if (length < 8 || !std::has_single_bit(length) || length > rate.size())
    throw Error(fmt::format("pieces of {} readings: expected a power of two from 8 to the record's {}", length, rate.size()));
  WelchSpectrum out{0, 1 / (static_cast<double>(length) * interval_s), std::vector<double>(length / 2 - 1)};
  std::vector<double> window(length), piece(length);
  double power = 0;
  for (std::size_t j = 0; j < length; ++j) {
    window[j] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(length));
    power += window[j] * window[j];
  }
  Eigen::FFT<double> fourier;
  std::vector<std::complex<double>> transform;
  for (std::size_t begin = 0; begin + length <= rate.size(); begin += length / 2, ++out.pieces) {
    double mean = 0;
    for (std::size_t j = 0; j < length; ++j) mean += (rate[begin + j] - rate[begin]) / static_cast<double>(length);
    for (std::size_t j = 0; j < length; ++j) piece[j] = window[j] * (rate[begin + j] - rate[begin] - mean);
    fourier.fwd(transform, piece);
    for (std::size_t k = 0; k < out.density.size(); ++k) out.density[k] += std::norm(transform[k + 1]);
  }
  for (double& density : out.density) density *= interval_s / (power * static_cast<double>(out.pieces));
  return out;
}

}  // namespace imulab
