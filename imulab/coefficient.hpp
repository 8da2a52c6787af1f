// The coefficient table, which lists name, unit and place of every coefficient of the sensor model once; and the customary units of each.
//
// Example:
//   const CoefficientIndex index = coefficient_index("gyro.matrix.xy");
//   const double value = coefficient_value(calibration.model, index);  // SI
//   for (const CoefficientIndex i : select_coefficients("accel.offset")) std::puts(coefficient(i).name.data());
//   const UserUnit unit = user_unit(coefficient(index), value);        // arcsec: value / unit.size
//
// A function that takes a name throws Error if it is unknown. Looking up a name is a pass over the 108 rows; an index needs no search. Safe on any
// thread.
#pragma once

#include "imulab/sensor_model.hpp"

#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

enum class Triad { accel, gyro };
enum class Term { offset, matrix, quadratic, cubic, thermal, matrix_thermal1, matrix_thermal2, g_sensitivity, lever_arm };

/// One row of the table. `row` is the output axis. `column` is the input axis (matrix, its thermal terms, g_sensitivity), the component (lever_arm)
/// or the order 1 to 3 (thermal); for the diagonal terms it equals `row`.
struct Coefficient {
  std::string_view name;  ///< "gyro.matrix.xy": triad.term.element; the first letter of the element is the row
  Triad triad;
  Term term;
  int row, column;
  std::string_view unit;  ///< SI; "raw" is the unit of the recording
};

/// A coefficient's index in the table. CoefficientIndex(4) makes one from a number; it converts to a number to address a row or column.
enum CoefficientIndex : int {};

/// Returns all coefficients in file order: accel offset 3, matrix 9, quadratic 3, cubic 3, thermal 9, matrix_thermal1 9, matrix_thermal2 9, lever_arm
/// 9; gyro likewise, with g_sensitivity 9 instead of lever_arm. (These are Dai's 63, minus the six thermal constants that the gauge fixes, plus nine
/// lever arm components, six thermal terms of third order, and the matrices' thermal terms.)
std::span<const Coefficient> coefficient_table();
inline constexpr int coefficient_count = 108;
/// Returns one row of the table. Throws Error if `index` is outside the table.
const Coefficient& coefficient(CoefficientIndex index);
/// Returns all indices in order.
std::span<const CoefficientIndex> coefficient_indices();

/// Returns the index of a coefficient from its triad, term, and `row` and `column` as in Coefficient.
CoefficientIndex coefficient_index(Triad triad, Term term, int row, int column);
/// Returns the index of a coefficient name; throws Error if it is unknown.
CoefficientIndex coefficient_index(std::string_view name);
/// Returns the indices of a selector: a name ("gyro.matrix.xy"), term ("accel.offset") or group ("gyro.matrix.diagonal" or ".off_diagonal").
/// "bias" in place of "offset" selects the same coefficients; a bias is an offset with the other sign.
std::vector<CoefficientIndex> select_coefficients(std::string_view selector);
/// Returns the indices of several selectors, in their order.
std::vector<CoefficientIndex> select_each(std::initializer_list<std::string_view> selectors);

/// Returns true for a scale factor: a diagonal element of a matrix.
bool is_scale(const Coefficient& coefficient);
/// Returns true for a term that an IMU model can omit: all except offset and matrix.
bool is_optional(Term term);

bool contains(const std::vector<CoefficientIndex>& indices, CoefficientIndex index);  ///< returns true if `index` is one of `indices`

/// Lists the faults of a list of coefficients: indices that are not in the table, or that occur twice.
std::vector<std::string> problems_of(const std::vector<CoefficientIndex>& indices);
/// Lists the faults of a model: coefficients or reference temperatures that are not finite.
std::vector<std::string> problems_of(const SensorModel& model);

inline const TriadModel& triad_model(const SensorModel& model, Triad triad) { return triad == Triad::accel ? model.accel : model.gyro; }
double coefficient_value(const SensorModel& model, CoefficientIndex index);  ///< returns the value [SI, raw unit of the model]
Eigen::VectorXd coefficient_values(const SensorModel& model, const std::vector<CoefficientIndex>& indices);  ///< one value per index
void set_coefficient(SensorModel& model, CoefficientIndex index, double value);                              ///< `value`: SI, raw unit of the model

/// Returns the terms of a triad in file order.
std::span<const Term> terms_of(Triad triad);
/// Returns true for the thermal terms of a matrix.
inline bool is_matrix_thermal(Term term) { return term == Term::matrix_thermal1 || term == Term::matrix_thermal2; }
/// Returns true for terms that act by the temperature alone.
inline bool is_thermal(Term term) { return term == Term::thermal || is_matrix_thermal(term); }
/// Returns true for terms that Dai's model lacks: the thermal ones of third order, and those of matrices.
inline bool is_extended(const Coefficient& c) { return is_matrix_thermal(c.term) || (c.term == Term::thermal && c.column == 3); }

/// Returns true for terms with three elements, one per axis (offset, quadratic, cubic). The other terms are 3x3 in the model and in files.
bool is_vector(Term term);

std::string_view to_string(Triad triad);  ///< returns "accel" or "gyro"
std::string_view to_string(Term term);    ///< returns the name of a term: "offset", "matrix", ...

// Customary units of differences and uncertainties of coefficients. For matrices, they are the units of D = M_b M_a^-1 - I.

struct UserUnit {
  std::string_view name;
  double size;  ///< SI value of one unit
};

/// Returns the unit of a quadratic, cubic or thermal term if the triad's readings are in SI (of a matrix's thermal term: in any): its effect at 1 g,
/// at 1 deg/s, per kelvin, or per unit of raw thermal readings.
UserUnit unit_of_si_readings(const Coefficient& coefficient, const TriadModel& triad);

/// Returns all units in which differences of the coefficient may be given, the usual one first; empty if the unit depends on the raw readings.
std::span<const UserUnit> user_units(const Coefficient& coefficient);

/// Returns the customary unit of the coefficient's differences; `size` is the largest difference of its term [SI]. If the unit depends on the raw
/// readings, the result is the table's unit (see unit_of_si_readings).
UserUnit user_unit(const Coefficient& coefficient, double size);

/// Returns the customary unit for the readings of `triad`: every term has one unless the readings are counts.
UserUnit user_unit(const Coefficient& coefficient, double size, const TriadModel& triad);

}  // namespace imulab
