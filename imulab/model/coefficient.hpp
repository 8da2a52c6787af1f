// The coefficient table: every coefficient of the sensor model, its name, unit and place, once. Nothing else parses a coefficient's name.
#pragma once

#include "imulab/model/sensor_model.hpp"

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
/// One row of the table.
const Coefficient& coefficient(CoefficientIndex index);
/// All places, in order.
std::span<const CoefficientIndex> coefficient_indices();

/// Place of a coefficient in the table.
CoefficientIndex coefficient_index(Triad triad, Term term, int row, int column);
/// Place of a name in the table; throws Error for an unknown one.
CoefficientIndex coefficient_index(std::string_view name);
/// Places of a selector: a name ("gyro.matrix.xy"), a term ("accel.offset") or a group ("gyro.matrix.diagonal", "gyro.matrix.off_diagonal").
std::vector<CoefficientIndex> select_coefficients(std::string_view selector);
/// Places of several selectors, in their order.
std::vector<CoefficientIndex> select_each(std::initializer_list<std::string_view> selectors);

/// True for a scale: on the diagonal of a matrix.
bool is_scale(const Coefficient& coefficient);
/// True for a term that an IMU may do without: all but offsets and matrices.
bool is_optional(Term term);

bool contains(const std::vector<CoefficientIndex>& indices, CoefficientIndex index);

inline const TriadModel& triad_model(const SensorModel& model, Triad triad) { return triad == Triad::accel ? model.accel : model.gyro; }
double coefficient_value(const SensorModel& model, CoefficientIndex index);
Eigen::VectorXd coefficient_values(const SensorModel& model, const std::vector<CoefficientIndex>& indices);
void set_coefficient(SensorModel& model, CoefficientIndex index, double value);

/// Three elements, one per axis (offset, quadratic, cubic); the other terms are 3x3 in the model and in files.
bool is_vector(Term term);

std::string_view to_string(Triad triad);
std::string_view to_string(Term term);

}  // namespace imulab
