// A coefficient as people know it: offsets in ug or mg and deg/h or deg/s, scales in ppm from one or in counts per unit, misalignments in arcsec.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/sensor_model.hpp"

#include <span>
#include <string>
#include <string_view>

namespace imulab {

struct UserValue {
  double value = 0;
  double uncertainty = 0;  ///< standard; NaN where it was not estimated
  std::string unit;        ///< the same for all coefficients of one term of a triad; empty where the readings are counts and the term has no name
};

/// A calibration's coefficient in user units. Scales: ppm from one, or counts per unit; misalignments: relative to their row's scale.
UserValue user_value(const Calibration& calibration, CoefficientIndex index);

/// The coefficient in `other`, for example the start of the fit, with the calibration's unit and uncertainty.
UserValue user_value(const Calibration& calibration, CoefficientIndex index, const SensorModel& other);

// Customary units of coefficients' differences and uncertainties. For matrices they are those of D = M_b M_a^-1 - I.

struct UserUnit {
  std::string_view name;
  double size;  ///< SI
};

/// The unit of a quadratic, cubic or thermal term of a triad whose readings are in SI: its effect at one g, at one deg/s or in one kelvin.
UserUnit unit_of_si_readings(const Coefficient& coefficient, const TriadModel& triad);

/// Every unit that a coefficient's differences may be given in, the usual one first; none for terms whose unit depends on the raw readings.
std::span<const UserUnit> user_units(const Coefficient& coefficient);

/// The customary unit of this coefficient's differences; `size` is the largest of its term [SI]. That of the table for terms whose unit depends on
/// the raw readings: see unit_of_si_readings.
UserUnit user_unit(const Coefficient& coefficient, double size);

/// The customary unit with the readings of this triad: a unit for every term, unless they are counts.
UserUnit user_unit(const Coefficient& coefficient, double size, const TriadModel& triad);

// The uncertainty of a coefficient as a certificate states it (GUM, JCGM 100): u, effective degrees of freedom, k, U.

/// SI. Type A is the uncertainty that the fit found from the data; type B is the declared uncertainty that is known separately: that of g, which
/// enters the accelerometers' scales. Declared errors of a rig and priors are part of the first: a calibration does not separate them.
struct ExpandedUncertainty {
  double standard = 0;            ///< u
  double from_fit = 0;            ///< type A
  double declared = 0;            ///< type B
  double degrees_of_freedom = 0;  ///< effective (Welch-Satterthwaite); infinite where the declared part dominates
  double coverage_factor = 0;     ///< k: 95.45 % of a t distribution
  double expanded = 0;            ///< U = k u
};

/// The uncertainty of an estimated coefficient. Throws Error for a coefficient without uncertainty.
ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index);

}  // namespace imulab
