// For tests of exports: a calibration that has every term.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"

#include <cmath>

namespace imulab {

inline double every_terms_value(CoefficientIndex index) {
  const Coefficient& k = coefficient(index);
  const bool diagonal = k.term == Term::matrix && k.row == k.column;
  const double sign = index % 2 && !diagonal ? -1 : 1, size = 1 + 0.1 * (index % 7);
  const auto plain = [&] {
    switch (k.term) {
      case Term::offset:
        return 0.1;
      case Term::matrix:
        return diagonal ? 2e-3 : 1e-5;
      case Term::quadratic:
        return 1e-9;
      case Term::cubic:
        return 1e-13;
      case Term::thermal:
        return k.column == 1 ? 2.5 : k.column == 2 ? 0.03 : 3e-4;
      case Term::matrix_thermal1:
        return 1e-4;
      case Term::matrix_thermal2:
        return 1e-6;
      case Term::g_sensitivity:
        return 1e-4;
      case Term::lever_arm:
        break;
    }
    return 0.0;
  };
  return sign * size * plain();
}

/// A unit in counts that uses every term, with a resonance frequency as the gyros' thermal reading and a hostile name.
inline Calibration every_term() {
  Calibration c;
  c.imu = "unit */ #include <x>";
  c.method = "truth";
  c.model.accel.raw_unit = c.model.gyro.raw_unit = "count";
  for (const CoefficientIndex index : coefficient_indices())
    if (const double value = every_terms_value(index); value != 0) set_coefficient(c.model, index, value);
  c.model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  c.model.gyro.temperature = ThermalReading{"raw", 4987.5, {4900, 5100}};
  c.covariance.resize(0, 0);
  return c;
}

/// That unit from readings in SI.
inline Calibration every_term_in_si() {
  constexpr double per_unit = 500;  // counts to one m/s^2 and to one rad/s
  Calibration c = every_term();
  for (TriadModel* t : {&c.model.accel, &c.model.gyro}) {
    t->matrix *= per_unit, t->quadratic *= per_unit * per_unit, t->cubic *= per_unit * per_unit * per_unit;
    t->thermal /= per_unit;
  }
  c.model.accel.raw_unit = "m/s^2", c.model.gyro.raw_unit = "rad/s";
  return c;
}

constexpr const char* header_warnings = " -O2 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror -o program";

}  // namespace imulab
