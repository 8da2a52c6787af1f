// The functions phi of the table of effects (effects.cpp) of state and column; `function` counts the functions of an axis i.
#pragma once

#include "imulab/model/effects.hpp"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstddef>

namespace imulab::effect_functions {

// The two axes of a triad that follow axis i.
constexpr int second(int i) { return (i + 1) % 3; }
constexpr int third(int i) { return (i + 2) % 3; }

/// Slow change in a recording, two functions each, with zero mean: proportional to time, and a warm-up with a quarter of it as time constant.
inline double slow(const EffectState& s, int function) {
  constexpr double mean_warm_up = 1 - 0.25 * (1 - 0.018315638888734179);  // mean of 1 - exp(-4 x) over 0 to 1: 1 - (1 - e^-4) / 4
  if (function / 2 != s.recording) return 0;
  return function % 2 == 0 ? s.time : 1 - std::exp(-4 * (s.time + 0.5)) - mean_warm_up;
}

inline double product(const Vector3d& v, int axis, int function) {
  const int i = axis, j = second(axis), k = third(axis);
  return function == 0 ? v[i] * v[j] : function == 1 ? v[i] * v[k] : v[j] * v[k];
}

inline double asymmetry_of_force(const EffectState& s, int i, int) { return std::abs(s.force[i]) - 0.5 * s.gravity; }
inline double asymmetry_of_rate(const EffectState& s, int i, int) { return std::abs(s.rate[i]); }
inline double cross_terms(const EffectState& s, int i, int function) {
  if (function < 3) return product(s.force, i, function);
  const double f = s.force[function == 3 ? second(i) : third(i)];
  return f * f - s.gravity * s.gravity / 3;
}
inline double hysteresis(const EffectState& s, int i, int) { return s.play[i]; }
inline double rectification(const EffectState& s, int i, int) { return s.shaking[i]; }
inline double anisoelasticity(const EffectState& s, int i, int function) {
  if (function < 3) return product(s.force, i, function);
  const double f = s.force[function == 3 ? i : function == 4 ? second(i) : third(i)];
  return f * f - s.gravity * s.gravity / 3;
}
inline double fourth_order(const EffectState& s, int i, int) {
  const double x = s.force[i] / s.full_force, at_rest = s.gravity / s.full_force;
  return (x * x * x * x - at_rest * at_rest * at_rest * at_rest / 5) * s.full_force;
}
inline double higher_orders(const EffectState& s, int i, int function) {
  const double x = s.rate[i] / s.full_rate, fourth = x * x * x * x * s.full_rate;
  return function == 0 ? fourth : x * fourth;
}
inline double offset_drift(const EffectState& s, int, int function) { return slow(s, function); }
inline double drift_in_force(const EffectState& s, int i, int function) { return slow(s, function) * s.force[i]; }
inline double force_in_rate(const EffectState& s, int i, int function) { return s.rate[i] * s.force[function]; }
inline double along_horizontal(const EffectState& s, int i, int function) { return s.horizontal[static_cast<std::size_t>(function)][i]; }
inline double drift_in_rate(const EffectState& s, int i, int function) { return slow(s, function) * s.rate[i]; }
inline double changed(const EffectState& s, int, int) { return s.changed; }
inline double changed_in_force(const EffectState& s, int i, int) { return s.changed * s.force[i]; }
inline double changed_in_rate(const EffectState& s, int i, int) { return s.changed * s.rate[i]; }
inline double warming(const EffectState& s, int, int) { return s.warming.value_or(0); }
/// Terms of c1 (d + l) + c2 (d + l)^2 / 50 K + c3 (d + l)^3 / (50 K)^2, whose coefficients are independent: powers of d, then those with l.
inline double thermal(const EffectState& s, int, int function) {
  const double d = s.warming.value_or(0), l = s.warming_rate * thermometer_lag_s, K = second_order_per_first;
  const std::array terms{
      d, d * d / K, d * d * d / (K * K), l, 2 * d * l / K, l * l / K, 3 * d * d * l / (K * K), 3 * d * l * l / (K * K), l * l * l / (K * K)};
  return terms[static_cast<std::size_t>(function)];
}
/// d, d^2 / 50 K, l or 2 d l / 50 K times an input.
template <Triad triad>
OutputChange matrix_over_temperature(const EffectState& s, int column) {
  const MatrixThermal m = matrix_thermal(triad, column);
  const double d = s.warming.value_or(0), l = s.warming_rate * thermometer_lag_s, first = m.lags ? l : d, second = (m.lags ? 2 * l : d) * d;
  const double size = m.order == 1 ? first : second / second_order_per_first;
  const Vector3d& input = triad == Triad::accel ? s.force : s.rate;
  const Vector3d change = m.size() * size * input[m.column] * Vector3d::Unit(m.row);
  return triad == Triad::accel ? OutputChange{.force = change} : OutputChange{.rate = change};
}
inline double warming_in_force(const EffectState& s, int i, int) { return s.warming.value_or(0) * s.force[i]; }
inline double warming_in_rate(const EffectState& s, int i, int) { return s.warming.value_or(0) * s.rate[i]; }

/// Shifts of the recordings' offsets with zero sum: the first `contrast + 1` against the next, orthonormal (Helmert's contrasts). With one sigma
/// each, these are independent switch-ons minus their mean.
inline double turn_on(const EffectState& s, int, int contrast) {
  const double before = contrast + 1, norm = std::sqrt(before * (before + 1));
  return s.recording <= contrast ? 1 / norm : s.recording == contrast + 1 ? -before / norm : 0;
}

/// Applies the same function to each axis of a triad: column 3 function + axis.
template <double (*phi)(const EffectState&, int axis, int function)>
inline OutputChange of_accels(const EffectState& s, int column) {
  return {.force = phi(s, column % 3, column / 3) * Vector3d::Unit(column % 3)};
}
template <double (*phi)(const EffectState&, int axis, int function)>
inline OutputChange of_gyros(const EffectState& s, int column) {
  return {.rate = phi(s, column % 3, column / 3) * Vector3d::Unit(column % 3)};
}

/// The unit rotates in its mount by K f: column 3 i + j is K_ij.
inline OutputChange elastic_mount(const EffectState& s, int column) {
  const Vector3d angle = s.force[column % 3] * Vector3d::Unit(column / 3);
  return {.force = s.force.cross(angle), .rate = s.rate.cross(angle)};
}

/// The unit rotates in its mount by a small angle about axis `column`.
inline OutputChange change_of_mount(const EffectState& s, int column) {
  const Vector3d angle = s.changed * Vector3d::Unit(column);
  return {.force = s.force.cross(angle), .rate = s.rate.cross(angle)};
}

inline OutputChange longer_arm(const EffectState& s, int) { return {.force = s.stretching}; }
inline OutputChange farther_north(const EffectState& s, int) { return s.by_latitude; }
inline OutputChange turned_about_up(const EffectState& s, int machine) { return machine == s.machine ? s.by_heading : OutputChange{}; }

/// The thermometers of accelerometers and gyros have a constant error in each recording.
inline OutputChange thermometer_error(const EffectState& s, int column) {
  if (column / 2 != s.recording) return {};
  return column % 2 == 0 ? OutputChange{.force = s.by_thermometer.force} : OutputChange{.rate = s.by_thermometer.rate};
}

}  // namespace imulab::effect_functions
