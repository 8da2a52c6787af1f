// Counts of numbers in bins of fixed relative width, which add up: quantiles of any number of numbers in bounded memory.
//
//   Histogram h;
//   for (const float x : sample) h.add(x);
//   h.quantile(0.95)
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

class Histogram {
 public:
  /// The width of a bin relative to its numbers: no quantile is off by more. One that is alone in its bin is exact.
  static constexpr double relative_width = 1.0 / 256;

  void add(float value);
  void add(const Histogram& other);
  std::uint64_t count() const;
  /// As `quantile` of a sample (core/statistics.hpp); NaN for none.
  double quantile(double p) const;

  void write(std::string& bytes) const;
  /// From the front of what `write` appended. Throws Error where it is cut or no histogram.
  void read(std::string_view& bytes);

 private:
  struct Bin {
    std::int32_t key = 0;  ///< the leading bits of the numbers, in their order
    std::uint64_t count = 0;
    double sum = 0;
  };
  Bin& bin(std::int32_t key);
  double of_rank(std::uint64_t rank) const;

  std::vector<Bin> bins_;  ///< by key
};

}  // namespace imulab
