#include "imulab/recording/quiet_noise.hpp"

#include "imulab/core/statistics.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace imulab {

double quiet_noise(const std::vector<double>& readings, const std::vector<Range>& rests, std::size_t block) {
  const auto n = static_cast<double>(block);
  std::vector<double> variances;
  for (const Range& rest : rests)
    for (std::size_t begin = rest.begin; begin + block <= rest.end; begin += block) {
      double mean = 0, squares = 0;
      for (std::size_t i = begin; i < begin + block; ++i) mean += readings[i] / n;
      for (std::size_t i = begin; i < begin + block; ++i) squares += (readings[i] - mean) * (readings[i] - mean);
      variances.push_back(squares / (n - 1));
    }
  if (variances.empty()) return std::numeric_limits<double>::infinity();
  const double of_median = std::pow(1 - 2 / (9 * (n - 1)), 3);  // a chi-square's over its mean (Wilson and Hilferty)
  return std::sqrt(median(std::move(variances)) / of_median);
}

}  // namespace imulab
