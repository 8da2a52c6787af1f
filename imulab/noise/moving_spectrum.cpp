#include "imulab/noise/moving_spectrum.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/noise/spectrum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace imulab::noise {
namespace {

constexpr double longest_piece_s = 8, slow_hz = 1;
/// Degrees of freedom of a Hann window with half overlap, relative to those of the record: (3/4)^2 / (9/16 + 1/32), by the sum of its squares.
constexpr double hann_share = 18.0 / 19;

/// Q(f): the fitted density, linear in its logarithms; outside its frequencies that at the nearest.
class DensityAtRest {
 public:
  explicit DensityAtRest(const NoiseFit& fit) : fit_(fit) {}
  double at(double hz) const {
    const auto& s = fit_.spectrum;
    if (s.empty()) return fit_.N.value * fit_.N.value;
    const auto above = std::partition_point(s.begin(), s.end(), [&](const SpectrumPoint& p) { return p.hz < hz; });
    if (above == s.begin()) return s.front().model;
    if (above == s.end()) return s.back().model;
    const SpectrumPoint &a = *(above - 1), &b = *above;
    return a.model * std::pow(b.model / a.model, std::log(hz / a.hz) / std::log(b.hz / a.hz));
  }

 private:
  const NoiseFit& fit_;
};

GroupMean group_mean(const std::vector<double>& groups) {
  const double n = static_cast<double>(groups.size()), mean = std::accumulate(groups.begin(), groups.end(), 0.0) / n;
  double square = 0;
  for (const double g : groups) square += (g - mean) * (g - mean);
  const double sigma = std::sqrt(square / (n * (n - 1)));
  return {mean, sigma, student_quantile(0.975, n - 1) * sigma};
}

/// Densities of the groups of a log, and Q, at frequencies (k + 1) spacing.
struct MovingDensities {
  std::vector<std::vector<double>> groups;
  std::vector<double> all, rest;
  double spacing = 0;

  double hz(std::size_t k) const { return static_cast<double>(k + 1) * spacing; }
  std::size_t from(double low_hz) const {
    return std::min(all.size(), static_cast<std::size_t>(std::max(0.0, std::ceil(low_hz / spacing * (1 - 1e-9)) - 1)));
  }
};

MovingDensities densities_of(std::span<const double> readings, double interval_s, const NoiseFit& rest, std::size_t groups) {
  const std::size_t length = readings.size() / groups;
  const auto piece = std::bit_floor(std::min(length, static_cast<std::size_t>(std::max(16.0, longest_piece_s / interval_s))));
  MovingDensities out;
  for (std::size_t g = 0; g < groups; ++g) {
    WelchSpectrum spectrum = welch_spectrum(readings.subspan(g * length, length), interval_s, piece);
    out.spacing = spectrum.spacing_hz;
    out.groups.push_back(std::move(spectrum.density));
  }
  const DensityAtRest density(rest);
  for (std::size_t k = 0; k < out.groups[0].size(); ++k) {
    double sum = 0;
    for (const auto& group : out.groups) sum += group[k];
    out.all.push_back(sum / static_cast<double>(groups)), out.rest.push_back(density.at(out.hz(k)));
  }
  return out;
}

struct Bins {
  std::size_t begin = 0, end = 0;
};

double ratio_in(const std::vector<double>& moving, const std::vector<double>& rest, const Bins& bins) {
  double sum = 0;
  for (std::size_t k = bins.begin; k < bins.end; ++k) sum += moving[k] / rest[k];
  return sum / static_cast<double>(bins.end - bins.begin);
}

/// Returns the bands without lines and resonances: those within three sigma of the mean of the bands within, from the lower quartile on.
std::vector<Bins> clean_bands(const MovingDensities& d, std::size_t first, double record_s) {
  constexpr std::size_t most_bands = 48;
  const std::size_t bins = d.all.size() - first, bands = std::min(most_bands, std::max<std::size_t>(1, bins / 2));
  std::vector<Bins> all;
  std::vector<double> ratios;
  for (std::size_t b = 0; b < bands; ++b) {
    all.push_back({first + b * bins / bands, first + (b + 1) * bins / bands});
    ratios.push_back(ratio_in(d.all, d.rest, all.back()));
  }
  const double freedom = 2 * hann_share * record_s * d.spacing * static_cast<double>(bins) / static_cast<double>(bands);
  const double limit = 1 + 3 * std::sqrt(2 / freedom);
  double floor = quantile(ratios, 0.25) * freedom / chi_square_quantile(0.25, freedom);
  std::vector<Bins> clean;
  for (int pass = 0; pass < 20; ++pass) {
    clean.clear();
    double sum = 0;
    for (std::size_t b = 0; b < bands; ++b)
      if (ratios[b] <= floor * limit) clean.push_back(all[b]), sum += ratios[b];
    floor = sum / static_cast<double>(clean.size());
  }
  return clean;
}

}  // namespace

MovingSpectrum moving_spectrum(std::span<const double> readings, double interval_s, const NoiseFit& rest, double vibration_hz, std::size_t groups) {
  const MovingDensities d = densities_of(readings, interval_s, rest, groups);
  const std::size_t first = std::min(d.from(vibration_hz), d.all.size() - 1);
  const std::vector<Bins> clean = clean_bands(d, first, interval_s * static_cast<double>(readings.size()));
  std::vector<double> floors, variances, derivatives, slow, scatters;
  double at_rest = 0;
  for (std::size_t k = first; k < d.rest.size(); ++k) at_rest += 2 * d.spacing * d.rest[k];
  for (const NoiseLine& line : rest.lines)
    if (line.hz >= vibration_hz) at_rest += 0.5 * line.amplitude.value * line.amplitude.value;
  constexpr std::size_t after_trend = 1;  // the lowest bin contains most of a drift
  const Bins low{after_trend, d.from(slow_hz)};
  for (const auto& group : d.groups) {
    double floor = 0, variance = 0, derivative = 0, scatter = 0;
    for (const Bins& bins : clean) floor += ratio_in(group, d.rest, bins) / static_cast<double>(clean.size());
    for (std::size_t k = 0; k < group.size(); ++k) {
      const double excess = 2 * d.spacing * (group[k] - floor * d.rest[k]);
      derivative += std::pow(2 * std::numbers::pi * d.hz(k), 2) * excess;
      if (k >= first) variance += excess, scatter += 2 * d.spacing * group[k] / at_rest;
    }
    floors.push_back(floor), variances.push_back(variance), derivatives.push_back(derivative), scatters.push_back(scatter);
    if (low.end > low.begin) slow.push_back(ratio_in(group, d.rest, low));
  }
  MovingSpectrum out{group_mean(floors), group_mean(variances), group_mean(derivatives), {}, group_mean(scatters), 0};
  constexpr std::size_t fewest_slow = 2;
  if (low.end >= low.begin + fewest_slow) out.slow = group_mean(slow);
  std::size_t strongest = first;
  for (std::size_t k = first; k < d.all.size(); ++k)
    if (d.all[k] - out.floor.value * d.rest[k] > d.all[strongest] - out.floor.value * d.rest[strongest]) strongest = k;
  out.strongest_hz = d.hz(strongest);
  return out;
}

bool raise_to_motion(std::vector<UpperDensity>& upper, std::span<const double> readings, double interval_s, const NoiseFit& rest, double lowest_hz,
                     double confidence) {
  constexpr std::size_t pieces = 8, shortest_piece = 16;
  constexpr double by_chance = 0.001;
  const WelchSpectrum spectrum = welch_spectrum(readings, interval_s, std::bit_floor(std::max(shortest_piece, readings.size() / pieces)));
  const double bins_freedom = 2 * hann_share * interval_s * static_cast<double>(readings.size()) * spectrum.spacing_hz;
  const auto bin_at = [&](double hz) {
    return std::min(spectrum.density.size(), static_cast<std::size_t>(std::max(0.0, hz / spectrum.spacing_hz - 0.5)));
  };
  bool raised = false;
  for (std::size_t i = 0; i < upper.size(); ++i) {
    const double below = i > 0 ? std::sqrt(upper[i - 1].hz * upper[i].hz) : upper[i].hz;
    const double above = i + 1 < upper.size() ? std::sqrt(upper[i].hz * upper[i + 1].hz) : upper[i].hz;
    const std::size_t begin = bin_at(below), end = bin_at(above);
    if (below < std::max(lowest_hz, spectrum.spacing_hz) || begin == end) continue;
    const double freedom = bins_freedom * static_cast<double>(end - begin);
    const double power = std::accumulate(spectrum.density.begin() + static_cast<std::ptrdiff_t>(begin),
                                         spectrum.density.begin() + static_cast<std::ptrdiff_t>(end), 0.0) /
                         static_cast<double>(end - begin);
    const double Q = rest.Q.determined ? 2 * rest.Q.value * std::sin(std::numbers::pi * upper[i].hz * interval_s) : 0,
                 quantization = Q * Q / interval_s;
    if (power * freedom / chi_square_quantile(1 - by_chance, freedom) <= upper[i].density + quantization) continue;
    upper[i].density = std::max(upper[i].density, power * freedom / chi_square_quantile(1 - confidence, freedom) - quantization);
    raised = true;
  }
  return raised;
}

}  // namespace imulab::noise
