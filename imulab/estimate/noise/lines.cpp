#include "imulab/estimate/noise/lines.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab::noise {

namespace {

constexpr std::size_t most_lines = 8, lowest_ordinate = 8, around = 10;
constexpr double chance = 1e-6;
constexpr double left_at_most = 0.3;  // of the excess about a line, once it is taken out

struct Peak {
  std::size_t level = 0, ordinate = 0;
  double hz = 0, noise = 0;  // density of the model there
};

/// The model's density at a frequency, between the bins' middles.
double density_at(const ChosenModel& model, const Eigen::ArrayXd& density, double hz) {
  const std::vector<SpectrumBin>& bins = model.problem.bins();
  const auto after = std::upper_bound(bins.begin(), bins.end(), hz, [](double f, const SpectrumBin& bin) { return f < bin.middle_hz(); });
  if (after == bins.begin()) return density[0];
  if (after == bins.end()) return density[density.size() - 1];
  const auto i = after - bins.begin();
  const double low = std::prev(after)->middle_hz(), part = (hz - low) / (after->middle_hz() - low);
  return density[i - 1] + part * (density[i] - density[i - 1]);
}

std::optional<Peak> highest_peak(const Spectrum& spectrum, const ChosenModel& model, const std::vector<double>& known) {
  const Eigen::ArrayXd density = model.problem.density(model.best.at);
  double ordinates = 0, most = 0;
  for (const SpectrumLevel& level : spectrum.levels) ordinates += static_cast<double>(level.end - level.first);
  std::optional<Peak> best;
  for (std::size_t l = 0; l < spectrum.levels.size(); ++l) {
    const SpectrumLevel& level = spectrum.levels[l];
    const double scatter = std::sqrt(2 / level.transforms), resolved = level.hz(3);
    for (std::size_t k = std::max(level.first, lowest_ordinate); k < level.end; ++k) {
      const double hz = level.hz(static_cast<double>(k)), noise = density_at(model, density, hz), ratio = level.power[k] / noise;
      if (ratio < 1 + 4 * scatter || (ratio - 1) / scatter <= most) continue;
      if (std::any_of(known.begin(), known.end(), [&](double f) { return std::abs(f - hz) < resolved; })) continue;
      if (chi_square_tail(ratio * level.transforms, level.transforms) > chance / ordinates) continue;
      most = (ratio - 1) / scatter;
      best = Peak{l, k, hz, noise};
    }
  }
  return best;
}

/// Power above the model's about a peak.
double excess(const Spectrum& spectrum, const Peak& peak) {
  const SpectrumLevel& level = spectrum.levels[peak.level];
  double sum = 0;
  for (std::size_t k = peak.ordinate - std::min(peak.ordinate, around); k < std::min(level.end, peak.ordinate + around + 1); ++k)
    sum += std::max(0.0, level.power[k] / peak.noise - 1);
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

WithoutLines without_lines(std::span<const double> rate, double interval_s, double resolution) {
  Spectrum spectrum = spectrum_of(rate, interval_s);
  ChosenModel model = choose_terms(spectrum, 0.5 / interval_s, resolution);
  WithoutLines out{std::move(spectrum), std::move(model), {}};
  std::vector<double> taken;
  while (taken.size() < most_lines) {
    const std::optional<Peak> peak = highest_peak(out.spectrum, out.model, taken);
    if (!peak) break;
    const SpectrumLevel& level = out.spectrum.levels[peak->level];
    taken.push_back(sharpened(rate, interval_s, peak->hz, level.interval * static_cast<double>(level.power.size())));
    Spectrum less = spectrum_of(rate, interval_s, taken);
    if (!(excess(less, *peak) < left_at_most * excess(out.spectrum, *peak))) break;  // broad: a misfit
    out.spectrum = std::move(less);
    out.model = fitted_again(out.model, out.spectrum, resolution);
    out.lines.push_back({taken.back(), amplitude_of(out.spectrum, *peak)});
  }
  if (!out.lines.empty()) out.model = choose_terms(out.spectrum, 0.5 / interval_s, resolution);
  std::sort(out.lines.begin(), out.lines.end(), [](const NoiseLine& a, const NoiseLine& b) { return a.hz < b.hz; });
  return out;
}

}  // namespace imulab::noise
