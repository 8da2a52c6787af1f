#include "imulab/noise/lines.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab::noise {

namespace {

constexpr std::size_t most_lines = 8, lowest_ordinate = 8, around = 5, shortest_block = 16, longest_block = 128;
constexpr double chance = 1e-3;       // of a line in a log without one
constexpr double left_at_most = 0.3;  // of the excess about a line, once it is taken out

struct Peak {
  std::size_t level = 0, ordinate = 0;
  double hz = 0, noise = 0;  // density about it
};

/// Density, and on how many degrees of freedom it rests.
struct Floor {
  double noise = 0, degrees = 0;
};

/// The median of ordinates on `transforms` degrees of freedom each, as a mean. Its variance is 1 / (4 n density^2) at the median.
class MedianFloor {
 public:
  explicit MedianFloor(double transforms) {
    const double median = chi_square_quantile(0.5, transforms), step = 1e-4 * median;
    const double density = (chi_square_tail(median - step, transforms) - chi_square_tail(median + step, transforms)) / (2 * step);
    of_one_ = median / transforms;
    degrees_of_one_ = 8 * std::pow(median * density, 2);
  }
  Floor operator()(const SpectrumLevel& level, std::size_t first, std::size_t end) const {
    const auto at = [&](std::size_t k) { return level.power.begin() + static_cast<std::ptrdiff_t>(k); };
    return {median({at(first), at(end)}) / of_one_, degrees_of_one_ * static_cast<double>(end - first)};
  }

 private:
  double of_one_ = 1, degrees_of_one_ = 0;
};

/// What is usual about each ordinate: in three blocks, longer at high frequency; below the third, as many ordinates on either side, since the median
/// of a spectrum that falls is then what it is in their middle.
std::vector<Floor> floors(const SpectrumLevel& level) {
  const MedianFloor floor(level.transforms);
  std::vector<Floor> out(level.end);
  std::size_t k = std::max(level.first, lowest_ordinate);
  for (; k < std::min(level.end, 3 * shortest_block); ++k) {
    const std::size_t side = std::min({k - level.first, level.end - 1 - k, 3 * shortest_block / 2});
    out[k] = floor(level, k - side, k + side + 1);
  }
  for (std::size_t length; k < level.end; k += length) {
    length = std::clamp(k / 8, shortest_block, longest_block);
    const Floor about = floor(level, std::max(level.first, k - length), std::min(level.end, k + 2 * length));
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(k), out.begin() + static_cast<std::ptrdiff_t>(std::min(level.end, k + length)), about);
  }
  return out;
}

/// Octaves of all levels, as logarithms: the chance of a false line is the same in each.
double log_range(const Spectrum& spectrum) {
  double sum = 0;
  for (const SpectrumLevel& level : spectrum.levels)
    if (const std::size_t first = std::max(level.first, lowest_ordinate); first < level.end)
      sum += std::log(static_cast<double>(level.end) / static_cast<double>(first));
  return sum;
}

std::optional<Peak> highest_peak(const Spectrum& spectrum, const std::vector<double>& known) {
  const double range = log_range(spectrum);
  double most = 0;
  std::optional<Peak> best;
  for (std::size_t l = 0; l < spectrum.levels.size(); ++l) {
    const SpectrumLevel& level = spectrum.levels[l];
    const std::vector<Floor> about = floors(level);
    const double scatter = std::sqrt(2 / level.transforms), resolved = level.hz(3);
    for (std::size_t k = std::max(level.first, lowest_ordinate); k < level.end; ++k) {
      const double hz = level.hz(static_cast<double>(k)), ratio = level.power[k] / about[k].noise;
      if (!(ratio > 1 + 4 * scatter) || (ratio - 1) / scatter <= most) continue;
      if (std::any_of(known.begin(), known.end(), [&](double f) { return std::abs(f - hz) < resolved; })) continue;
      if (f_tail(ratio, level.transforms, about[k].degrees) > chance / (range * static_cast<double>(k))) continue;
      most = (ratio - 1) / scatter;
      best = Peak{l, k, hz, about[k].noise};
    }
  }
  return best;
}

/// Power above the noise about a peak.
double excess(const Spectrum& spectrum, const Peak& peak) {
  const SpectrumLevel& level = spectrum.levels[peak.level];
  double sum = 0;
  for (std::size_t k = peak.ordinate - std::min(peak.ordinate, around); k < std::min(level.end, peak.ordinate + around + 1); ++k)
    sum += level.power[k] / peak.noise - 1;
  return sum;
}

/// Of the last sinusoid that was removed: its mean square less what the noise alone gives.
NoiseCoefficient amplitude_of(const Spectrum& spectrum, const Peak& peak) {
  constexpr double coverage = 1.96;
  NoiseCoefficient c;
  c.value = std::sqrt(std::max(0.0, spectrum.squares / spectrum.pieces - 4 * peak.noise / spectrum.piece_s));
  c.standard_uncertainty = std::sqrt(2 * peak.noise / (spectrum.piece_s * spectrum.pieces));
  c.lower = std::max(0.0, c.value - coverage * c.standard_uncertainty), c.upper = c.value + coverage * c.standard_uncertainty;
  c.determined = c.lower > 0;
  return c;
}

}  // namespace

WithoutLines without_lines(std::span<const double> rate, double interval_s) {
  WithoutLines out{spectrum_of(rate, interval_s), {}};
  std::vector<double> taken;
  while (taken.size() < most_lines) {
    const std::optional<Peak> peak = highest_peak(out.spectrum, taken);
    if (!peak) break;
    const SpectrumLevel& level = out.spectrum.levels[peak->level];
    taken.push_back(sharpened(rate, interval_s, peak->hz, level.interval * static_cast<double>(level.power.size())));
    Spectrum less = spectrum_of(rate, interval_s, taken);
    if (!(excess(less, *peak) < left_at_most * excess(out.spectrum, *peak))) break;  // not one frequency
    out.spectrum = std::move(less);
    out.lines.push_back({taken.back(), amplitude_of(out.spectrum, *peak)});
  }
  std::sort(out.lines.begin(), out.lines.end(), [](const NoiseLine& a, const NoiseLine& b) { return a.hz < b.hz; });
  return out;
}

}  // namespace imulab::noise
