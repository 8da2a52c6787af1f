// Customary units of coefficients' differences and uncertainties. For matrices they are those of D = M_b M_a^-1 - I.
#pragma once

#include "imulab/model/coefficient.hpp"
#include "imulab/model/sensor_model.hpp"

#include <span>
#include <string_view>

namespace imulab {

struct UserUnit {
  std::string_view name;
  double size;  ///< SI
};

/// Of a quadratic, cubic or thermal term of a triad whose readings are in SI: what it adds at one g, at one deg/s or in one kelvin.
UserUnit unit_of_si_readings(const Coefficient& coefficient, const TriadModel& triad);

/// Every unit that a coefficient's differences may be given in, the usual one first; none for terms whose unit depends on the raw readings.
std::span<const UserUnit> user_units(const Coefficient& coefficient);

/// The customary unit of this coefficient's differences; `size` is the largest of its term [SI]. That of the table for terms whose unit depends on
/// the raw readings: see unit_of_si_readings.
UserUnit user_unit(const Coefficient& coefficient, double size);

/// The same with the readings of this triad: a unit for every term, unless they are counts.
UserUnit user_unit(const Coefficient& coefficient, double size, const TriadModel& triad);

}  // namespace imulab
