#include "imulab/model/user_unit.hpp"

#include "imulab/core/units.hpp"

#include <array>
#include <cmath>

namespace imulab {

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
    const bool raw = triad.temperature && triad.temperature->unit == "raw", square = c.column == 2;
    if (accel) return {raw ? (square ? "ug/raw^2" : "ug/raw") : (square ? "ug/K^2" : "ug/K"), unit::ug};
    return {raw ? (square ? "deg/h/raw^2" : "deg/h/raw") : (square ? "deg/h/K^2" : "deg/h/K"), unit::deg_per_h};
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
  return scaled && size >= 1e4 * units[0].size ? units[1] : units[0];  // a low-grade IMU in mg, deg/s and deg/s/g
}

UserUnit user_unit(const Coefficient& c, double size, const TriadModel& triad) {
  return user_units(c).empty() && triad.raw_unit != "count" ? unit_of_si_readings(c, triad) : user_unit(c, size);
}

}  // namespace imulab
