#include "imulab/fleet/statistics/due.hpp"

#include "imulab/core/statistics.hpp"

#include <cmath>
#include <limits>

namespace imulab {

double years_until(const Aging& a, double limit) {
  const double factor = normal_quantile(0.975);
  const auto bound = [&](double years) {
    const double since = a.since_middle + years;
    return std::abs(a.level + a.slope * since) + factor * std::hypot(a.level_sigma, a.repeatability, a.slope_sigma * since);
  };
  // It may fall before it rises, where the last calibration is on the side to which the unit drifts: in steps, then exactly.
  constexpr double step = due_horizon / 4000;
  double years = 0;
  if (bound(0) >= limit) return 0;
  while (bound(years + step) < limit)
    if ((years += step) >= due_horizon) return std::numeric_limits<double>::infinity();
  double low = years, high = years + step;
  while (high - low > 1e-9 * due_horizon) (bound(0.5 * (low + high)) < limit ? low : high) = 0.5 * (low + high);
  return low;
}

Slope slopes_of(const RandomEffects& d) {
  const double of_mean = 0.25 * (d.mean_high - d.mean_low);  // about its standard uncertainty
  return {d.mean, d.spread_high * d.spread_high + of_mean * of_mean};
}

Slope slope_among(const Slope& fleet, const Slope& own) {
  if (!(fleet.variance > 0)) return fleet;  // all units drift alike
  const double variance = 1 / (1 / fleet.variance + 1 / own.variance);
  return {variance * (fleet.mean / fleet.variance + own.mean / own.variance), variance};
}

}  // namespace imulab
