// The coefficient table: every coefficient of the sensor model, its name, unit and place, once; and the customary units of each.
//
// Example:
//   const CoefficientIndex index = coefficient_index("gyro.matrix.xy");
//   const double value = coefficient_value(calibration.model, index);  // SI
//   for (const CoefficientIndex i : select_coefficients("accel.offset")) std::puts(coefficient(i).name.data());
//   const UserUnit unit = user_unit(coefficient(index), value);        // arcsec: value / unit.size
//
// Names throw Error where they are unknown. Looking up a name takes a pass over the 66 rows; an index none. Safe on any thread.
#pragma once

#include "imulab/sensor_model.hpp"

#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

enum class Triad { accel, gyro };
enum class Term { offset, matrix, quadratic, cubic, thermal, g_sensitivity, lever_arm };

/// One row of the table. `row` is the output axis; `column` the input axis (matrix, g_sensitivity), the component (lever_arm) or the
/// order 1, 2 (thermal); for the diagonal terms it equals `row`.
struct Coefficient {
  std::string_view name;  ///< "gyro.matrix.xy": triad.term.element, first letter the row
  Triad triad;
  Term term;
  int row, column;
  std::string_view unit;  ///< SI; "raw" is the recording's unit
};

/// Place of a coefficient in the table: made from a number explicitly, CoefficientIndex(4); converts to a number to address a row or column.
enum CoefficientIndex : int {};

/// All coefficients in file order: accel offset 3, matrix 9, quadratic 3, cubic 3, thermal 6, lever_arm 9; gyro likewise with g_sensitivity 9.
/// (Dai's 63 less the six thermal constants the gauge fixes, plus nine lever-arm components.)
std::span<const Coefficient> coefficient_table();
inline constexpr int coefficient_count = 66;
/// One row of the table. Throws Error for an index that is not in it.
const Coefficient& coefficient(CoefficientIndex index);
/// All places, in order.
std::span<const CoefficientIndex> coefficient_indices();

/// Place of a coefficient in the table.
CoefficientIndex coefficient_index(Triad triad, Term term, int row, int column);
/// Place of a name in the table; throws Error for an unknown one.
CoefficientIndex coefficient_index(std::string_view name);
/// Places of a selector: a name ("gyro.matrix.xy"), a term ("accel.offset") or a group ("gyro.matrix.diagonal", "gyro.matrix.off_diagonal"). "bias" is
/// another word for "offset", which has the other sign.
std::vector<CoefficientIndex> select_coefficients(std::string_view selector);
/// Places of several selectors, in their order.
std::vector<CoefficientIndex> select_each(std::initializer_list<std::string_view> selectors);

/// True for a scale: on the diagonal of a matrix.
bool is_scale(const Coefficient& coefficient);
/// True for a term that an IMU may do without: all but offsets and matrices.
bool is_optional(Term term);

bool contains(const std::vector<CoefficientIndex>& indices, CoefficientIndex index);

/// What is wrong with a list of coefficients: indices that are not in the table, or in the list twice.
std::vector<std::string> problems_of(const std::vector<CoefficientIndex>& indices);
/// What is wrong with a model: coefficients or reference temperatures that are not finite.
std::vector<std::string> problems_of(const SensorModel& model);

inline const TriadModel& triad_model(const SensorModel& model, Triad triad) { return triad == Triad::accel ? model.accel : model.gyro; }
double coefficient_value(const SensorModel& model, CoefficientIndex index);
Eigen::VectorXd coefficient_values(const SensorModel& model, const std::vector<CoefficientIndex>& indices);
void set_coefficient(SensorModel& model, CoefficientIndex index, double value);

/// Three elements, one per axis (offset, quadratic, cubic); the other terms are 3x3 in the model and in files.
bool is_vector(Term term);

std::string_view to_string(Triad triad);
std::string_view to_string(Term term);

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

}  // namespace imulab
