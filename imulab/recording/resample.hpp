// Columns of one clock on the stamps of another: sensors that are read at different rates or instants.
#pragma once

#include <cstdint>
#include <vector>

namespace imulab {

/// One value a stamp, and whether the source covers it.
struct Resampled {
  std::vector<std::vector<double>> columns;
  std::vector<char> covered;  ///< not where the source has a gap there, or has not begun or has ended
};

/// Readings as means over the intervals that end at `at` (the first interval and those after gaps have the length `interval_s`). A reading stands for
/// the interval that ends at its own stamp, so what accumulates, an angle or a velocity, is kept. `increment`: readings are sums over their
/// intervals, before and after. Stamps [ns] ascend; a source interval longer than one and a half `source_interval_s` is a gap.
Resampled resample_means(const std::vector<std::int64_t>& time_ns, double source_interval_s, const std::vector<std::vector<double>>& columns,
                         bool increment, const std::vector<std::int64_t>& at, double interval_s);

/// Readings of a slow quantity at `at`: on straight lines between their stamps, and as at the nearest one before the first and after the last.
std::vector<std::vector<double>> interpolate(const std::vector<std::int64_t>& time_ns, const std::vector<std::vector<double>>& columns,
                                             const std::vector<std::int64_t>& at);

}  // namespace imulab
