#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace imulab {

namespace {

/// Returns the largest value of a term, because all of its coefficients share one unit.
double largest_of_term(const Calibration& calibration, const Coefficient& c) {
  double largest = 0;
  for (const CoefficientIndex other : coefficient_indices())
    if (coefficient(other).triad == c.triad && coefficient(other).term == c.term)
      largest = std::max(largest, std::abs(coefficient_value(calibration.model, other)));
  return largest;
}

/// Returns the value for readings in counts.
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
  if (is_matrix_thermal(c.term)) return in(unit_of_si_readings(c, triad));
  if (triad.raw_unit == "count") return of_counts(c, calibration, model, value, sigma);
  if (c.term == Term::offset) return in(user_unit(c, largest_of_term(calibration, c)));
  if (c.term == Term::matrix) return {(value - 1) / unit::ppm, sigma / unit::ppm, "ppm"};
  return in(unit_of_si_readings(c, triad));
}

UserValue user_value(const Calibration& calibration, CoefficientIndex index) { return user_value(calibration, index, calibration.model); }

namespace {

constexpr std::array accel_offset{UserUnit{"ug", unit::ug}, UserUnit{"mg", 1e3 * unit::ug}, UserUnit{"g", unit::g}, UserUnit{"m/s^2", 1}};
constexpr std::array gyro_offset{UserUnit{"deg/h", unit::deg_per_h}, UserUnit{"deg/s", unit::deg}, UserUnit{"rad/s", 1}};
constexpr std::array scale_error{UserUnit{"ppm", unit::ppm}, UserUnit{"%", 1e-2}, UserUnit{"arcsec", unit::arcsec}, UserUnit{"rad", 1}};
constexpr std::array misalignment{UserUnit{"arcsec", unit::arcsec}, UserUnit{"arcmin", 60 * unit::arcsec},
                                  UserUnit{"deg", unit::deg},       UserUnit{"ppm", unit::ppm},
                                  UserUnit{"mrad", 1e-3},           UserUnit{"rad", 1}};
constexpr std::array g_sensitivity{UserUnit{"deg/h/g", unit::deg_per_h / unit::g}, UserUnit{"deg/s/g", unit::deg / unit::g}};
constexpr std::array lever_arm{UserUnit{"mm", 1e-3}, UserUnit{"m", 1}};

}  // namespace

UserUnit unit_of_si_readings(const Coefficient& c, const TriadModel& triad) {
  const bool accel = c.triad == Triad::accel;
  if (c.term == Term::thermal) {
    constexpr std::array<std::array<std::string_view, 3>, 4> names{{{"ug/K", "ug/K^2", "ug/K^3"},
                                                                    {"deg/h/K", "deg/h/K^2", "deg/h/K^3"},
                                                                    {"ug/raw", "ug/raw^2", "ug/raw^3"},
                                                                    {"deg/h/raw", "deg/h/raw^2", "deg/h/raw^3"}}};
    const bool raw = triad.temperature && triad.temperature->unit == "raw";
    return {names[(accel ? 0 : 1) + (raw ? 2 : 0)][static_cast<std::size_t>(c.column - 1)], accel ? unit::ug : unit::deg_per_h};
  }
  if (is_matrix_thermal(c.term)) {
    constexpr std::array<std::array<std::string_view, 2>, 4> names{
        {{"ppm/K", "ppm/K^2"}, {"arcsec/K", "arcsec/K^2"}, {"ppm/raw", "ppm/raw^2"}, {"arcsec/raw", "arcsec/raw^2"}}};
    const bool raw = triad.temperature && triad.temperature->unit == "raw", scale = c.row == c.column;
    return {names[(scale ? 0 : 1) + (raw ? 2 : 0)][c.term == Term::matrix_thermal1 ? 0 : 1], scale ? unit::ppm : unit::arcsec};
  }
  const int order = c.term == Term::quadratic ? 2 : 3;
  if (accel) return {order == 2 ? "ug/g^2" : "ug/g^3", unit::ug / std::pow(unit::g, order)};
  return {order == 2 ? "ppm/(deg/s)" : "ppb/(deg/s)^2", (order == 2 ? unit::ppm : 1e-9) / std::pow(unit::deg, order - 1)};
}

std::span<const UserUnit> user_units(const Coefficient& c) {
  switch (c.term) {
    case Term::offset:
      return c.triad == Triad::accel ? std::span<const UserUnit>(accel_offset) : std::span<const UserUnit>(gyro_offset);
    case Term::matrix:
      return c.row == c.column ? std::span<const UserUnit>(scale_error) : std::span<const UserUnit>(misalignment);
    case Term::g_sensitivity:
      return g_sensitivity;
    case Term::lever_arm:
      return lever_arm;
    case Term::matrix_thermal1:
    case Term::matrix_thermal2:
    case Term::quadratic:
    case Term::cubic:
    case Term::thermal:
      break;
  }
  return {};
}

UserUnit user_unit(const Coefficient& c, double size) {
  const std::span<const UserUnit> units = user_units(c);
  if (units.empty()) return {c.unit, 1};
  const bool scaled = c.term == Term::offset || c.term == Term::g_sensitivity;
  return scaled && size >= 1e4 * units[0].size ? units[1] : units[0];  // a low-grade IMU uses mg, deg/s and deg/s/g
}

UserUnit user_unit(const Coefficient& c, double size, const TriadModel& triad) {
  return user_units(c).empty() && (triad.raw_unit != "count" || is_matrix_thermal(c.term)) ? unit_of_si_readings(c, triad) : user_unit(c, size);
}

namespace {

double declared_part(const Calibration& calibration, CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  if (c.triad != Triad::accel || !is_scale(c)) return 0;
  double square = 0;
  for (const UncertaintySource& source : calibration.quality.sources) square += source.relative * source.relative;
  return std::sqrt(square) * std::abs(coefficient_value(calibration.model, index));
}

}  // namespace

double coverage_factor(double degrees_of_freedom) {
  constexpr double level = 0.9545;  // two sigma of a normal distribution, two-sided
  return student_quantile(0.5 * (1 + level), degrees_of_freedom);
}

ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  const auto u = standard_uncertainty(calibration, index);
  if (!u) throw Error(std::string(coefficient(index).name) + " has no uncertainty");
  ExpandedUncertainty out;
  out.standard = *u;
  out.declared = declared_part(calibration, index);
  if (out.declared > *u) out.declared = 0;  // the data determine the quantity better than the declaration: no part is separate
  out.from_fit = std::sqrt(std::max(0.0, *u * *u - out.declared * out.declared));
  const double of_fit = std::max(1, calibration.quality.degrees_of_freedom);
  const double part = *u > 0 ? out.from_fit / *u : 0;
  out.degrees_of_freedom = part > 0.01 ? of_fit / std::pow(part, 4) : std::numeric_limits<double>::infinity();
  out.coverage_factor = coverage_factor(out.degrees_of_freedom);
  out.expanded = out.coverage_factor * *u;
  return out;
}

}  // namespace imulab
