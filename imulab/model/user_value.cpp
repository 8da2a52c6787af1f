#include "imulab/model/user_value.hpp"

#include "imulab/core/units.hpp"
#include "imulab/model/user_unit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

/// The largest value of a term: one unit for all of its coefficients.
double largest_of_term(const Calibration& calibration, const Coefficient& c) {
  double largest = 0;
  for (const CoefficientIndex other : coefficient_indices())
    if (coefficient(other).triad == c.triad && coefficient(other).term == c.term)
      largest = std::max(largest, std::abs(coefficient_value(calibration.model, other)));
  return largest;
}

/// Readings in counts.
UserValue of_counts(const Coefficient& c, Calibration calibration, const SensorModel& model, double value, double sigma) {
  if (c.term == Term::matrix) return {1 / value, sigma / (value * value), c.triad == Triad::accel ? "count/(m/s^2)" : "count/(rad/s)"};
  if (c.term != Term::offset) return {value, sigma, ""};
  calibration.model = model;
  const RawZero zero = raw_zero(calibration, c.triad);
  return {zero.value[c.row], zero.uncertainty[c.row], "count at zero"};
}

}  // namespace

UserValue user_value(const Calibration& calibration, CoefficientIndex index, const SensorModel& model) {
  const Coefficient& c = coefficient(index);
  const TriadModel& triad = triad_model(model, c.triad);
  const double value = coefficient_value(model, index);
  const double sigma = standard_uncertainty(calibration, index).value_or(std::numeric_limits<double>::quiet_NaN());
  const auto in = [&](const UserUnit& unit) { return UserValue{value / unit.size, sigma / unit.size, std::string(unit.name)}; };
  if (c.term == Term::matrix && c.row != c.column) {
    const double scale = std::abs(triad.matrix(c.row, c.row)) * unit::arcsec;
    return {value / scale, sigma / scale, "arcsec"};
  }
  if (c.term == Term::g_sensitivity || c.term == Term::lever_arm) return in(user_unit(c, largest_of_term(calibration, c)));
  if (triad.raw_unit == "count") return of_counts(c, calibration, model, value, sigma);
  if (c.term == Term::offset) return in(user_unit(c, largest_of_term(calibration, c)));
  if (c.term == Term::matrix) return {(value - 1) / unit::ppm, sigma / unit::ppm, "ppm"};
  return in(unit_of_si_readings(c, triad));
}

UserValue user_value(const Calibration& calibration, CoefficientIndex index) { return user_value(calibration, index, calibration.model); }

}  // namespace imulab
