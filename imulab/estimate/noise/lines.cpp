#include "imulab/estimate/noise/lines.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab::noise {

namespace {

constexpr std::size_t most_lines = 8, lowest_ordinate = 8, around = 5, block = 16;
constexpr double chance = 1e-6;
constexpr double left_at_most = 0.3;  // of the excess about a line, once it is taken out

struct Peak {
  std::size_t level = 0, ordinate = 0;
  double hz = 0, noise = 0;  // density about it
};

/// The median over three blocks of ordinates, one value a block, as a mean: over the median of chi-square.
std::vector<double> noise_about(const SpectrumLevel& level) {
  const double median_of_one = chi_square_quantile(0.5, level.transforms) / level.transforms;
  std::vector<double> out((level.end + block - 1) / block), about;
  for (std::size_t b = 0; b < out.size(); ++b) {
    const std::size_t first = std::max(level.first, (b == 0 ? 0 : b - 1) * block), last = std::min(level.end, (b + 2) * block);
    if (first >= last) continue;
    about.assign(level.power.begin() + static_cast<std::ptrdiff_t>(first), level.power.begin() + static_cast<std::ptrdiff_t>(last));
    out[b] = median(about) / median_of_one;
  }
  return out;
}

std::optional<Peak> highest_peak(const Spectrum& spectrum, const std::vector<double>& known) {
  double ordinates = 0, most = 0;
  for (const SpectrumLevel& level : spectrum.levels) ordinates += static_cast<double>(level.end - level.first);
  std::optional<Peak> best;
  for (std::size_t l = 0; l < spectrum.levels.size(); ++l) {
    const SpectrumLevel& level = spectrum.levels[l];
    const std::vector<double> about = noise_about(level);
    const double scatter = std::sqrt(2 / level.transforms), resolved = level.hz(3);
    for (std::size_t k = std::max(level.first, lowest_ordinate); k < level.end; ++k) {
      const double hz = level.hz(static_cast<double>(k)), noise = about[k / block], ratio = level.power[k] / noise;
      if (!(ratio > 1 + 4 * scatter) || (ratio - 1) / scatter <= most) continue;
      if (std::any_of(known.begin(), known.end(), [&](double f) { return std::abs(f - hz) < resolved; })) continue;
      if (chi_square_tail(ratio * level.transforms, level.transforms) > chance / ordinates) continue;
      most = (ratio - 1) / scatter;
      best = Peak{l, k, hz, noise};
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
