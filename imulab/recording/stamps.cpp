#include "imulab/recording/stamps.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

constexpr std::size_t rows = 16;  // stamps that scatter by a fifth of an interval leave a twelfth on the difference of two medians

}  // namespace

double clock_interval(const std::vector<std::int64_t>& time_ns, double nominal_s) {
  if (time_ns.size() < 4 * rows) return nominal_s;
  std::vector<double> lengths;
  for (std::size_t i = rows; i < time_ns.size(); ++i) lengths.push_back(static_cast<double>(time_ns[i] - time_ns[i - rows]));
  const double interval = 1e-9 * median(std::move(lengths)) / rows;
  return std::abs(interval - nominal_s) <= 0.02 * nominal_s ? interval : nominal_s;  // further off are lost rows in every sixteen
}

double clock_step(const std::vector<std::int64_t>& time_ns, std::size_t i, double interval_s, std::size_t begin, std::size_t end) {
  const auto phase = [&](std::size_t first, std::size_t last) {
    std::vector<double> off;
    for (std::size_t k = first; k < last; ++k)
      off.push_back(1e-9 * static_cast<double>(time_ns[k] - time_ns[i]) / interval_s - (static_cast<double>(k) - static_cast<double>(i)));
    return median(std::move(off));
  };
  return phase(i, std::min(end, i + rows)) - phase(std::max(begin, i - std::min(i, rows)), i);
}

}  // namespace imulab
