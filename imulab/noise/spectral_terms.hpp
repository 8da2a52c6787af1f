// Densities of the noise terms in a bin of the spectrum: two-sided [u^2/Hz], of means over the transform's interval.
#pragma once

#include "imulab/noise/spectrum.hpp"

#include <cstddef>
#include <vector>

namespace imulab::noise {

/// Densities of Q^2, B^2, K^2 = 1 (model/imu_noise.hpp); the density of N^2 = 1 is 1.
struct Densities {
  double Q = 0, B = 0, K = 0;
};
Densities unit_densities(const SpectrumBin& bin);

/// cos(2 pi f T) in the middle of a bin.
double cosine_over_interval(const SpectrumBin& bin);

/// Density of a first-order Gauss-Markov process of unit variance. Fastest where bins of one interval follow each other.
class MarkovDensity {
 public:
  explicit MarkovDensity(double time_s) : time_s_(time_s) {}
  double at(double interval_s, double cosine);

 private:
  double time_s_, interval_s_ = 0;
  double g0_ = 0, g1_ = 0, a_ = 0;  // the covariances of means over the interval: g0, then g1 a^(k-1) at k intervals; `at` is their sum with cosines
};

/// A Butterworth filter before the readings are taken; or one that runs at their rate, by the bilinear transform.
struct LowPassShape {
  int order = 0;  ///< 0: none
  bool digital = false;
  bool operator==(const LowPassShape&) const = default;
};

/// The share of the power that a filter passes, and its derivative by the logarithm of the cutoff.
struct Passed {
  double share = 1, by_log_cutoff = 0;
};

/// A filter's shares in the bins of a spectrum, of noise that falls with frequency, and of white noise: of means over many readings with the
/// frequencies that averaging folds in; of readings of a filter before them with those that sampling folds in, so that one passes at frequency 0.
class FilterShares {
 public:
  FilterShares() = default;
  FilterShares(const std::vector<SpectrumBin>& bins, const LowPassShape& shape);

  struct Shares {
    std::vector<Passed> red, white;  ///< by bin
  };
  Shares at(double cutoff_hz) const;

 private:
  struct Node {
    double x, weight;  // the frequency as the filter's slope goes with it
  };
  /// Nodes of all bins; those of bin i are from begin[i] to begin[i + 1].
  struct Nodes {
    void add(const Node& node) { square.push_back(node.x * node.x), weight.push_back(node.weight); }
    std::vector<double> square, weight;  // x^2 and weight of each node: columns, of which the processor takes several numbers at once
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
