#include "imulab/model/expanded_uncertainty.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace imulab {

namespace {

/// Two sigma of a normal distribution, on both sides.
constexpr double level = 0.9545;

double declared_part(const Calibration& calibration, CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  if (c.triad != Triad::accel || !is_scale(c)) return 0;
  double square = 0;
  for (const UncertaintySource& source : calibration.quality.sources) square += source.relative * source.relative;
  return std::sqrt(square) * std::abs(coefficient_value(calibration.model, index));
}

}  // namespace

ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  const auto u = standard_uncertainty(calibration, index);
  if (!u) throw Error(std::string(coefficient(index).name) + " has no uncertainty");
  ExpandedUncertainty out;
  out.standard = *u;
  out.declared = declared_part(calibration, index);
  if (out.declared > *u) out.declared = 0;  // the data know the quantity better than the declaration: no part of it stands apart
  out.from_fit = std::sqrt(std::max(0.0, *u * *u - out.declared * out.declared));
  const double of_fit = std::max(1, calibration.quality.degrees_of_freedom);
  const double part = *u > 0 ? out.from_fit / *u : 0;
  out.degrees_of_freedom = part > 0.01 ? of_fit / std::pow(part, 4) : std::numeric_limits<double>::infinity();
  out.coverage_factor = student_quantile(0.5 * (1 + level), out.degrees_of_freedom);
  out.expanded = out.coverage_factor * *u;
  return out;
}

}  // namespace imulab
