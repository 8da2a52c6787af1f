#include "imulab/noise/spectral_terms.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace imulab::noise {

namespace {

using std::numbers::pi;

/// Returns the ratio of flicker power in an ordinate to its density, which is below one because the transform mirrors the record at its ends: the
/// integral of the density times the squared Fourier transform of the cosine; 1 - 2 / (pi^2 k) from k = 4 on, within 0.1 %.
double mirrored_flicker(std::size_t k) {
  constexpr std::array<double, 4> first{0, 0.7737, 0.9028, 0.9311};
  return k < first.size() ? first[k] : 1 - 2 / (pi * pi * static_cast<double>(k));
}

/// Returns (sin(n x) / (n sin x))^2, the response of the mean of n readings.
double mean_of(std::size_t n, double x) {
  const double nn = static_cast<double>(n), sine = std::sin(x);
  return std::abs(sine) < 1e-12 ? 1 : std::pow(std::sin(nn * x) / (nn * sine), 2);
}

constexpr std::size_t most_folds = 6;  // caused by averaging

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

double cosine_over_interval(const SpectrumBin& bin) { return std::cos(2 * pi * bin.middle_hz() * bin.interval); }

double MarkovDensity::at(double interval_s, double cosine) {
  if (interval_s != interval_s_) {
    interval_s_ = interval_s;
    const double x = interval_s / time_s_, lost = -std::expm1(-x);
    a_ = std::exp(-x);
    g0_ = x > 1e-3 ? 2 * (x - lost) / (x * x) : 1 - x / 3 + x * x / 12, g1_ = lost * lost / (x * x);
  }
  return interval_s * (g0_ + 2 * g1_ * (cosine - a_) / (1 - 2 * a_ * cosine + a_ * a_));
}

// The slope of a digital filter depends on the tangent of half the angle (bilinear transform).
double FilterShares::place(double hz) const { return shape_.digital ? std::tan(pi * std::min(hz * reading_s_, 0.4999)) : hz; }

/// Returns the origins of white noise at a frequency of the readings: sampling folds frequencies above half the rate that an analog filter passes.
std::vector<FilterShares::Node> FilterShares::sampled(double hz, double weight) const {
  if (shape_.digital) return {{place(hz), weight}};
  std::vector<Node> out;
  for (int fold = -2; fold <= 2; ++fold) out.push_back({std::abs(hz + fold / reading_s_), weight});
  return out;
}

FilterShares::FilterShares(const std::vector<SpectrumBin>& bins, const LowPassShape& shape) : shape_(shape) {
  if (bins.empty() || shape.order == 0) return;
  reading_s_ = bins.front().interval / static_cast<double>(bins.front().averaged);
  for (const SpectrumBin& bin : bins) add_bin(bin);
  for (const Node& node : sampled(0, 1)) zero_.add(node);
  zero_.begin.push_back(zero_.weight.size());
}

void FilterShares::add_bin(const SpectrumBin& bin) {
  double rest = 1;
  // Simpson's rule over the bin: a fourth-order filter decreases by a factor of 1.5 across one.
  for (const auto& [hz, weight] : {std::pair{bin.low_hz(), 1.0 / 6}, std::pair{bin.middle_hz(), 4.0 / 6}, std::pair{bin.high_hz(), 1.0 / 6}}) {
    red_.add({place(hz), weight});
    if (bin.averaged == 1) {
      for (const Node& node : sampled(hz, weight)) white_.add(node);
      continue;
    }
    const double of_mean = weight * mean_of(bin.averaged, pi * hz * reading_s_);
    white_.add({place(hz), of_mean});
    rest -= of_mean;
  }
  if (bin.averaged > 1) {
    const double folding = 1 / bin.interval;
    const std::size_t folds = std::min(most_folds, (bin.averaged - 1) / 2);
    for (std::size_t j = 1; j <= folds; ++j)
      for (const double side : {-1.0, 1.0}) {
        const double f = static_cast<double>(j) * folding + side * bin.middle_hz(), of_mean = mean_of(bin.averaged, pi * f * reading_s_);
        white_.add({place(f), of_mean});
        rest -= of_mean;
      }
    white_.add({place((static_cast<double>(folds) + 1) * folding), rest});
  }
  red_.begin.push_back(red_.weight.size());
  white_.begin.push_back(white_.weight.size());
}

/// Returns for each bin the sum over nodes of weight / (1 + (x / cutoff)^2n); `steepness`: d ln cutoff / d ln (cutoff frequency).
std::vector<Passed> FilterShares::passed(const Nodes& nodes, double cutoff, double steepness) const {
  const auto count = static_cast<Eigen::Index>(nodes.weight.size());
  const Eigen::Map<const Eigen::ArrayXd> square(nodes.square.data(), count), weight(nodes.weight.data(), count);
  const Eigen::ArrayXd ratio = square * (1 / (cutoff * cutoff));
  Eigen::ArrayXd power = ratio;
  for (int i = 1; i < shape_.order; ++i) power *= ratio;
  const Eigen::ArrayXd share = 1 / (1 + power), part = weight * share, change = part * power * share * (2 * shape_.order * steepness);
  std::vector<Passed> bins(nodes.begin.size() - 1, Passed{0, 0});
  for (std::size_t b = 0; b < bins.size(); ++b)
    for (std::size_t i = nodes.begin[b]; i < nodes.begin[b + 1]; ++i) {
      bins[b].share += part[static_cast<Eigen::Index>(i)];
      bins[b].by_log_cutoff += change[static_cast<Eigen::Index>(i)];
    }
  return bins;
}

FilterShares::Shares FilterShares::at(double cutoff_hz) const {
  const double angle = 2 * pi * cutoff_hz * reading_s_, cutoff = place(cutoff_hz), steepness = shape_.digital ? angle / std::sin(angle) : 1;
  Shares out{passed(red_, cutoff, steepness), passed(white_, cutoff, steepness)};
  const std::vector<Passed> at_zero = passed(zero_, cutoff, steepness);
  for (std::size_t i = 0; i < out.white.size(); ++i) {
    if (white_.begin[i + 1] - white_.begin[i] != 3 * zero_.weight.size() || shape_.digital) continue;
    Passed& white = out.white[i];
    const Passed& zero = at_zero.front();
    white.share /= zero.share;
    white.by_log_cutoff = (white.by_log_cutoff - white.share * zero.by_log_cutoff) / zero.share;
  }
  return out;
}

}  // namespace imulab::noise
