// Rejects outliers sample by sample, with a delay of two samples (docs/reference/compensate.md).
//
// Example:
//   OutlierFilter filter;
//   if (const auto out = filter.push({0, 0, 0, 0, 0, 9.8})) std::printf("%g\n", out->readings[5]);  // empty for the first two
//   while (const auto out = filter.rest()) std::printf("%g\n", out->readings[5]);                   // at the end: the last two
//
// Each channel is processed independently. Let a <= b be the middle two of a sample's four neighbors, two before and two after it. Let p be the value
// of the cubic through these four neighbors at the sample x:
//
//   d = distance of x from [a, b]                         zero in a monotone window
//   x is an outlier if min(d, |x - p|) > K s + 3 q        |x - p| is small where the motion is smooth; x becomes (a + b) / 2
//   s += w (min(d, K s + 3 q) - s)                        the usual d: an outlier raises it by no more than the largest allowed
//
// If x is between a and b, s does not change, because a slope contains no information about the noise. The weight w is 1/n for the n-th window used,
// but at least 1/100. The resolution q of rounded readings is the smallest nonzero difference of two successive readings.
//
// Readings may have any unit; raw readings are filtered before `compensate`. Each IMU needs a filter of its own because the filter has a state. Only
// one thread at a time may use it. A sample takes 40 ns; the filter does not allocate and does not throw.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// The state of six channels, in any order. NaN passes through and does not change the state.
class OutlierFilter {
 public:
  static constexpr double usual_factor = 10;  ///< K
  static constexpr double resolutions = 3;    ///< factor of q
  static constexpr int memory = 100;          ///< largest n for the weights 1/n
  static constexpr std::size_t delay = 2;     ///< samples
  /// Number of windows used to initialize a channel's s; until then, none of its samples is replaced.
  static constexpr std::size_t learning = 64;

  using Readings = std::array<double, 6>;
  struct Output {
    Readings readings;
    std::uint8_t replaced = 0;  ///< bit i: channel i was replaced
  };

  /// Throws Error unless `factor` (K) is finite and above 0.
  explicit OutlierFilter(double factor = usual_factor);

  /// Takes the next sample and returns the filtered sample two earlier; empty for the first two.
  std::optional<Output> push(const Readings& readings);
  /// Returns the last two samples unchanged, one per call, at the end of a recording; then returns empty.
  std::optional<Output> rest();

 private:
  void learn_resolution();
  Output judge();

  double factor_;
  std::array<Readings, 5> window_{};  // oldest first
  std::size_t taken_ = 0, given_ = 0;
  Readings resolution_{};              // q; 0: unknown
  Readings usual_{};                   // s; during initialization, the sum of d
  Readings taught_{};                  // numbers of windows used
  std::array<Readings, 2> largest_{};  // two largest d during initialization: they may be outliers
};

/// Filters six columns of a whole recording in place with the factor K; returns each sample's replaced channels as bits.
std::vector<std::uint8_t> reject_outliers(const std::array<std::span<double>, 6>& columns, double factor = OutlierFilter::usual_factor);

}  // namespace imulab
