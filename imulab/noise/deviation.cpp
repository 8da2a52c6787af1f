#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/degrees_of_freedom.hpp"
#include "imulab/noise/phase.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

using noise::SquareSum;

bool is_hadamard(DeviationKind kind) { return kind == DeviationKind::hadamard || kind == DeviationKind::overlapping_hadamard; }

/// Returns the span of one term in averaging factors.
std::size_t reach(DeviationKind kind) {
  if (kind == DeviationKind::total) return 1;
  return is_hadamard(kind) || kind == DeviationKind::modified_allan ? 3 : 2;
}

/// Returns the ratio of the mean square to the variance (times the squared averaging factor).
double scale(DeviationKind kind) { return is_hadamard(kind) ? 6 : 2; }

std::vector<SquareSum> square_sums(const std::vector<double>& phase, const std::vector<std::size_t>& factors, DeviationKind kind) {
  if (kind == DeviationKind::overlapping_allan) return noise::second_differences(phase, factors);
  if (kind == DeviationKind::overlapping_hadamard) return noise::third_differences(phase, factors);
  std::vector<SquareSum> sums;
  for (const std::size_t m : factors)
    sums.push_back(kind == DeviationKind::modified_allan ? noise::modified_differences(phase, m)
                   : kind == DeviationKind::total        ? noise::total_differences(phase, m)
                                                         : noise::strided_differences(phase, m, is_hadamard(kind) ? 3 : 2));
  return sums;
}

double edf_of(const DeviationPoint& point, std::size_t points, DeviationKind kind) {
  if (kind == DeviationKind::total && point.noise_type <= 0)
    return std::max(1.0, noise::total_degrees_of_freedom(static_cast<double>(points - 1) / static_cast<double>(point.factor), point.noise_type));
  const bool strided = kind == DeviationKind::allan || kind == DeviationKind::hadamard;
  // Beyond half the record, a total deviation has the degrees of freedom of an overlapping one at half of it.
  const std::size_t m = kind == DeviationKind::total ? std::min(point.factor, (points - 1) / 2) : point.factor;
  return noise::degrees_of_freedom({is_hadamard(kind) ? 3 : 2, points, m, !strided, kind == DeviationKind::modified_allan}, point.noise_type);
}

void set_bounds(DeviationPoint& point) {
  const auto bound = [&](double p) { return point.deviation * std::sqrt(point.edf / chi_square_quantile(p, point.edf)); };
  constexpr double one_sigma = 0.158655253931457;  // probability that a normal variable is below minus one sigma
  point.lower_68 = bound(1 - one_sigma);
  point.upper_68 = bound(one_sigma);
  point.lower_95 = bound(0.975);
  point.upper_95 = bound(0.025);
}

std::vector<std::size_t> possible_factors(std::size_t readings, double interval_s, const std::vector<std::size_t>& factors, DeviationKind kind) {
  if (readings < 3) throw Error(fmt::format("{} readings: too few; expected at least 3", readings));
  if (!(interval_s > 0) || std::isinf(interval_s)) throw Error(fmt::format("interval {:g} s: expected a positive time", interval_s));
  std::vector<std::size_t> possible;
  for (const std::size_t m : factors) {
    if (m == 0) throw Error("averaging factor 0: expected at least 1");
    if (m <= readings / reach(kind)) possible.push_back(m);
  }
  return possible;
}

std::vector<DeviationPoint> points_of(const std::vector<double>& phase, double interval_s, const std::vector<std::size_t>& factors,
                                      DeviationKind kind) {
  const std::vector<SquareSum> sums = square_sums(phase, factors, kind);
  std::vector<DeviationPoint> points;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    DeviationPoint point;
    const auto m = static_cast<double>(point.factor = factors[k]);
    point.tau = m * interval_s;
    point.terms = sums[k].terms;
    point.deviation = std::sqrt(sums[k].sum / (scale(kind) * static_cast<double>(point.terms))) / m;
    point.noise_type = noise::noise_type(phase, point.factor, is_hadamard(kind) ? -4 : -2);
    point.edf = edf_of(point, phase.size(), kind);
    set_bounds(point);
    points.push_back(point);
  }
  return points;
}

}  // namespace

std::optional<DeviationKind> deviation_kind(std::string_view name) {
  const auto found = std::find(deviation_names.begin(), deviation_names.end(), name);
  if (found == deviation_names.end()) return {};
  return static_cast<DeviationKind>(found - deviation_names.begin());
}

std::vector<std::size_t> averaging_factors(std::size_t samples) {
  std::vector<std::size_t> factors;
  for (std::size_t m = 1; m < 4 && m <= samples / 3; ++m) factors.push_back(m);
  for (std::size_t step = 1; 4 * step <= samples / 3; step *= 2)
    for (std::size_t k = 4; k < 8 && k * step <= samples / 3; ++k) factors.push_back(k * step);
  return factors;
}

std::vector<DeviationPoint> deviation(std::span<const double> rate, double interval_s, const std::vector<std::size_t>& factors, DeviationKind kind) {
  std::vector<double> copy;
  copy.reserve(rate.size() + 1);
  copy.assign(rate.begin(), rate.end());
  return deviation_in_place(std::move(copy), interval_s, factors, kind);
}

std::vector<DeviationPoint> deviation_in_place(std::vector<double>&& rate, double interval_s, const std::vector<std::size_t>& factors,
                                               DeviationKind kind) {
  const std::vector<std::size_t> possible = possible_factors(rate.size(), interval_s, factors, kind);
  return points_of(noise::phase_of(std::move(rate)), interval_s, possible, kind);
}

}  // namespace imulab
