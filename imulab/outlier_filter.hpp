// Rejection of outliers, sample by sample, two samples late (docs/reference/compensate.md).
//
// Example:
//   OutlierFilter filter;
//   if (const auto out = filter.push({0, 0, 0, 0, 0, 9.8})) std::printf("%g\n", out->readings[5]);  // nothing for the first two
//   while (const auto out = filter.rest()) std::printf("%g\n", out->readings[5]);                   // at the end: the last two
//
// Each channel on its own. With a <= b the middle two of a sample's four neighbors, two before and two after it, and p the value at the
// sample x of the cubic through the four,
//
//   d = distance of x from [a, b]                         zero in a monotone window
//   x is an outlier if min(d, |x - p|) > K s + 3 q        |x - p| is small where the motion is smooth; x becomes (a + b) / 2
//   s += w (min(d, K s + 3 q) - s)                        the usual d: an outlier raises it by no more than the largest allowed
//
// where x lies between a and b s does not change, since a slope does not show the noise. w = 1/n for the n-th window learned from, 1/100 at least.
// q, the resolution of rounded readings, is the smallest nonzero difference of two successive readings.
//
// Readings are in any unit, raw ones before `compensate`. A filter has a state: one for each IMU, used by one thread at a time. 40 ns a sample, no
// allocation, no errors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// The state of six channels, in any order. NaN passes, and nothing is learned from it.
class OutlierFilter {
 public:
  static constexpr double usual_factor = 10;   ///< K
  static constexpr double resolutions = 3;     ///< of q
  static constexpr int memory = 100;           ///< windows
  static constexpr std::size_t delay = 2;      ///< samples
  static constexpr std::size_t learning = 64;  ///< windows from which a channel's s is first learned: until then none of its samples is replaced

  using Readings = std::array<double, 6>;
  struct Output {
    Readings readings;
    std::uint8_t replaced = 0;  ///< bit i: channel i
  };

  /// Throws Error for a factor that is not finite and above 0.
  explicit OutlierFilter(double factor = usual_factor);

  /// Takes the next sample and gives the one two earlier; nothing for the first two.
  std::optional<Output> push(const Readings& readings);
  /// At the end of a recording, called until it gives nothing: the last two samples, as they were.
  std::optional<Output> rest();

 private:
  void learn_resolution();
  Output judge();

  double factor_;
  std::array<Readings, 5> window_{};  // the oldest first
  std::size_t taken_ = 0, given_ = 0;
  Readings resolution_{};              // q; 0: not seen yet
  Readings usual_{};                   // s; while it is first learned, the sum of d
  Readings taught_{};                  // windows learned from
  std::array<Readings, 2> largest_{};  // while s is first learned, its two largest d: they may be outliers
};

/// The filter on six columns of a whole recording, in place; returns each sample's replaced channels.
std::vector<std::uint8_t> reject_outliers(const std::array<std::span<double>, 6>& columns, double factor = OutlierFilter::usual_factor);

}  // namespace imulab
