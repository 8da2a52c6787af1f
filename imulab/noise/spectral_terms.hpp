// Densities of the noise terms in a bin of the spectrum: two-sided [u^2/Hz], for means over the interval of the transform.
#pragma once

#include "imulab/noise/spectrum.hpp"

#include <cstddef>
#include <numbers>
#include <vector>

namespace imulab::noise {

inline constexpr double flicker_floor_squared = 2 * std::numbers::ln2 / std::numbers::pi;  ///< Allan variance for B^2 = 1

/// Densities for Q^2, B^2, K^2 = 1 (imulab/grade.hpp); the density for N^2 = 1 is 1.
struct Densities {
  double Q = 0, B = 0, K = 0;
};
Densities unit_densities(const SpectrumBin& bin);

/// Returns cos(2 pi f T) at the middle of a bin.
double cosine_over_interval(const SpectrumBin& bin);

/// Density of a first-order Gauss-Markov process with unit variance. It is fastest if bins with one interval are consecutive.
class MarkovDensity {
 public:
  explicit MarkovDensity(double time_s) : time_s_(time_s) {}
  double at(double interval_s, double cosine);

 private:
  double time_s_, interval_s_ = 0;
  double g0_ = 0, g1_ = 0, a_ = 0;  // covariances of means over the interval: g0, then g1 a^(k-1) at k intervals; `at` is their sum with cosines
};

/// A Butterworth filter before sampling, or one at the sampling rate by the bilinear transform.
struct LowPassShape {
  int order = 0;  ///< 0: no filter
  bool digital = false;
  bool operator==(const LowPassShape&) const = default;
};

/// The fraction of the power that passes a filter, and its derivative by the logarithm of the cutoff.
struct Passed {
  double share = 1, by_log_cutoff = 0;
};

/// The passed fractions in the bins of a spectrum, for noise that falls with frequency and for white noise: for means over many readings including
/// frequencies folded by averaging; for readings after an analog filter including frequencies folded by sampling, normalized to one at frequency 0.
class FilterShares {
 public:
  FilterShares() = default;
  FilterShares(const std::vector<SpectrumBin>& bins, const LowPassShape& shape);

  struct Shares {
    std::vector<Passed> red, white;  ///< fractions for each bin
  };
  Shares at(double cutoff_hz) const;

 private:
  struct Node {
    double x, weight;  // x is the frequency on the scale of the filter's slope
  };
  /// Nodes of all bins; bin i has those from begin[i] to begin[i + 1].
  struct Nodes {
    void add(const Node& node) { square.push_back(node.x * node.x), weight.push_back(node.weight); }
    std::vector<double> square, weight;  // x^2 and weight of each node, as columns for vector instructions
    std::vector<std::size_t> begin{0};
  };
  double place(double hz) const;
  std::vector<Passed> passed(const Nodes& nodes, double cutoff, double steepness) const;
  void add_bin(const SpectrumBin& bin);
  std::vector<Node> sampled(double hz, double weight) const;

  LowPassShape shape_;
  double reading_s_ = 1;
  Nodes red_, white_;
  Nodes zero_;  // white noise at frequency 0, as one bin
};

}  // namespace imulab::noise
