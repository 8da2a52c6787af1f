#include "imulab/fleet/statistics/drift.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

/// One unit's calibrations.
struct History {
  std::vector<Eigen::Index> rows;
  double first = 0, last = 0;
};

std::vector<History> histories_of(const DriftInput& input) {
  std::vector<History> out(input.unit.empty() ? 0 : static_cast<std::size_t>(*std::max_element(input.unit.begin(), input.unit.end())) + 1);
  for (std::size_t k = 0; k < input.unit.size(); ++k) {
    History& h = out[static_cast<std::size_t>(input.unit[k])];
    const double t = input.time[static_cast<Eigen::Index>(k)];
    h.first = h.rows.empty() ? t : std::min(h.first, t);
    h.last = h.rows.empty() ? t : std::max(h.last, t);
    h.rows.push_back(static_cast<Eigen::Index>(k));
  }
  return out;
}

struct Line {
  double slope = 0, variance = 0, middle = 0, mean = 0, mean_variance = 0;  // at the middle time
  double squares = 0;                                                       // of the residuals, weighted
};

Line line_through(const DriftInput& in, const History& h, double additional) {
  Line l;
  double w = 0, wt = 0, wy = 0;
  for (const Eigen::Index k : h.rows) {
    const double a = 1 / (in.variances[k] + additional);
    w += a, wt += a * (in.time[k] - h.first), wy += a * in.values[k];
  }
  l.middle = h.first + wt / w, l.mean = wy / w, l.mean_variance = 1 / w;
  double tt = 0, ty = 0;
  for (const Eigen::Index k : h.rows) {
    const double a = 1 / (in.variances[k] + additional), t = in.time[k] - l.middle;
    tt += a * t * t, ty += a * t * (in.values[k] - l.mean);
  }
  l.slope = tt > 0 ? ty / tt : 0, l.variance = tt > 0 ? 1 / tt : 0;
  for (const Eigen::Index k : h.rows) {
    const double r = in.values[k] - l.mean - l.slope * (in.time[k] - l.middle);
    l.squares += r * r / (in.variances[k] + additional);
  }
  return l;
}

bool has_line(const History& h) { return h.rows.size() >= 2 && h.last > h.first; }

double all_squares(const DriftInput& in, const std::vector<History>& histories, double additional) {
  double sum = 0;
  for (const History& h : histories)
    if (has_line(h) && h.rows.size() > 2) sum += line_through(in, h, additional).squares;
  return sum;
}

/// The additional variance with which the residuals are as large as their number says; 0 where they are smaller without any.
double additional_of(const DriftInput& in, const std::vector<History>& histories, double freedom) {
  if (!(freedom > 0) || all_squares(in, histories, 0) <= freedom) return 0;
  double low = 0, high = in.variances.maxCoeff();
  while (all_squares(in, histories, high) > freedom) high *= 4;
  for (int k = 0; k < 60 && high - low > 1e-9 * high; ++k)
    (all_squares(in, histories, 0.5 * (low + high)) > freedom ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

double two_sided(double ratio, double freedom) {
  const double z = std::abs(ratio);
  if (std::isinf(freedom)) return chi_square_tail(z * z, 1);
  return f_tail(z * z, 1, freedom);
}

}  // namespace

FleetDrift fleet_drift(const DriftInput& input, double confidence) {
  FleetDrift out;
  const std::vector<History> histories = histories_of(input);
  for (const History& h : histories)
    if (has_line(h)) out.degrees_of_freedom += static_cast<double>(h.rows.size()) - 2;
  const double additional = additional_of(input, histories, out.degrees_of_freedom);
  out.repeatability = std::sqrt(additional);
  if (out.degrees_of_freedom > 0) out.p_value = chi_square_tail(all_squares(input, histories, 0), out.degrees_of_freedom);
  const double freedom = additional > 0 ? out.degrees_of_freedom : std::numeric_limits<double>::infinity();
  const double factor = student_quantile(0.5 + 0.5 * confidence, freedom);
  for (std::size_t unit = 0; unit < histories.size(); ++unit) {
    const History& h = histories[unit];
    if (!has_line(h)) continue;
    const Line l = line_through(input, h, additional);
    const double u = std::sqrt(l.variance);
    out.units.push_back({.unit = static_cast<Eigen::Index>(unit),
                         .calibrations = static_cast<int>(h.rows.size()),
                         .span = h.last - h.first,
                         .slope = l.slope,
                         .low = l.slope - factor * u,
                         .high = l.slope + factor * u,
                         .uncertainty = u,
                         .since_middle = h.last - l.middle,
                         .level = l.mean,
                         .level_uncertainty = std::sqrt(l.mean_variance),
                         .p_value = two_sided(l.slope / u, freedom),
                         .last = l.mean + l.slope * (h.last - l.middle)});
  }
  return out;
}

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
