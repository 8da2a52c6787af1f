#include "imulab/model/effects.hpp"

#include "imulab/units.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>

namespace imulab {

namespace {

using namespace unit;

// The axes of a triad after axis i.
constexpr int second(int i) { return (i + 1) % 3; }
constexpr int third(int i) { return (i + 2) % 3; }

/// Slow change in a recording, two functions each: in proportion to time, and as a warm-up whose time constant is a quarter of the recording; both
/// less their mean.
double slow(const EffectState& s, int function) {
  constexpr double mean_warm_up = 1 - 0.25 * (1 - 0.018315638888734179);  // of 1 - exp(-4 x) over 0 to 1: 1 - (1 - e^-4) / 4
  if (function / 2 != s.recording) return 0;
  return function % 2 == 0 ? s.time : 1 - std::exp(-4 * (s.time + 0.5)) - mean_warm_up;
}

double product(const Vector3d& v, int axis, int function) {
  const int i = axis, j = second(axis), k = third(axis);
  return function == 0 ? v[i] * v[j] : function == 1 ? v[i] * v[k] : v[j] * v[k];
}

double asymmetry_of_force(const EffectState& s, int i, int) { return std::abs(s.force[i]) - 0.5 * s.gravity; }
double asymmetry_of_rate(const EffectState& s, int i, int) { return std::abs(s.rate[i]); }
double cross_terms(const EffectState& s, int i, int function) {
  if (function < 3) return product(s.force, i, function);
  const double f = s.force[function == 3 ? second(i) : third(i)];
  return f * f - s.gravity * s.gravity / 3;
}
double hysteresis(const EffectState& s, int i, int) { return s.play[i]; }
double rectification(const EffectState& s, int i, int) { return s.shaking[i]; }
double anisoelasticity(const EffectState& s, int i, int function) {
  if (function < 3) return product(s.force, i, function);
  const double f = s.force[function == 3 ? i : function == 4 ? second(i) : third(i)];
  return f * f - s.gravity * s.gravity / 3;
}
double fourth_order(const EffectState& s, int i, int) {
  const double x = s.force[i] / s.full_force, at_rest = s.gravity / s.full_force;
  return (x * x * x * x - at_rest * at_rest * at_rest * at_rest / 5) * s.full_force;
}
double higher_orders(const EffectState& s, int i, int function) {
  const double x = s.rate[i] / s.full_rate, fourth = x * x * x * x * s.full_rate;
  return function == 0 ? fourth : x * fourth;
}
double offset_drift(const EffectState& s, int, int function) { return slow(s, function); }
double drift_in_force(const EffectState& s, int i, int function) { return slow(s, function) * s.force[i]; }
double force_in_rate(const EffectState& s, int i, int function) { return s.rate[i] * s.force[function]; }
double along_horizontal(const EffectState& s, int i, int function) { return s.horizontal[static_cast<std::size_t>(function)][i]; }
double drift_in_rate(const EffectState& s, int i, int function) { return slow(s, function) * s.rate[i]; }
double changed(const EffectState& s, int, int) { return s.changed; }
double changed_in_force(const EffectState& s, int i, int) { return s.changed * s.force[i]; }
double changed_in_rate(const EffectState& s, int i, int) { return s.changed * s.rate[i]; }
double warming(const EffectState& s, int, int) { return s.warming.value_or(0); }
double warming_in_force(const EffectState& s, int i, int) { return s.warming.value_or(0) * s.force[i]; }
double warming_in_rate(const EffectState& s, int i, int) { return s.warming.value_or(0) * s.rate[i]; }

/// Shifts of the recordings' offsets, of sum zero: the first `contrast + 1` against the next one, orthonormal (Helmert's contrasts). With one sigma
/// each, the shifts are those of independent switch-ons less their mean.
double turn_on(const EffectState& s, int, int contrast) {
  const double before = contrast + 1, norm = std::sqrt(before * (before + 1));
  return s.recording <= contrast ? 1 / norm : s.recording == contrast + 1 ? -before / norm : 0;
}

/// The same function of each axis of a triad: column 3 function + axis.
template <double (*phi)(const EffectState&, int axis, int function)>
OutputChange of_accels(const EffectState& s, int column) {
  return {.force = phi(s, column % 3, column / 3) * Vector3d::Unit(column % 3)};
}
template <double (*phi)(const EffectState&, int axis, int function)>
OutputChange of_gyros(const EffectState& s, int column) {
  return {.rate = phi(s, column % 3, column / 3) * Vector3d::Unit(column % 3)};
}

/// The unit turns in its mount by K f: column 3 i + j by K_ij.
OutputChange elastic_mount(const EffectState& s, int column) {
  const Vector3d angle = s.force[column % 3] * Vector3d::Unit(column / 3);
  return {.force = s.force.cross(angle), .rate = s.rate.cross(angle)};
}

/// The unit turns in its mount by a small angle, about axis `column`.
OutputChange change_of_mount(const EffectState& s, int column) {
  const Vector3d angle = s.changed * Vector3d::Unit(column);
  return {.force = s.force.cross(angle), .rate = s.rate.cross(angle)};
}

OutputChange longer_arm(const EffectState& s, int) { return {.force = s.stretching}; }
OutputChange farther_north(const EffectState& s, int) { return s.by_latitude; }
OutputChange turned_about_up(const EffectState& s, int machine) { return machine == s.machine ? s.by_heading : OutputChange{}; }

/// The thermometers of the accelerometers and of the gyros are off by a constant in each recording.
OutputChange thermometer_error(const EffectState& s, int column) {
  if (column / 2 != s.recording) return {};
  return column % 2 == 0 ? OutputChange{.force = s.by_thermometer.force} : OutputChange{.rate = s.by_thermometer.rate};
}

constexpr double force_squared = ug / (g * g), g_squared = deg_per_h / (g * g);
constexpr unsigned need_accel = Effect::of_accel, need_gyro = Effect::of_gyro;

// Sizes: docs/theory/effects.md has their sources.
constexpr std::array table{
    Effect{.name = "accel.asymmetry",
           .needs = need_accel,
           .basis = 3,
           .phi = of_accels<asymmetry_of_force>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {2, 10, 100, 1000},
           .declared = "accel_asymmetry_sigma_ppm",
           .words = "the accelerometers' scales differ between the two directions",
           .advice = "add rests with each axis at 45 deg to gravity"},
    Effect{.name = "gyro.asymmetry",
           .needs = need_gyro,
           .basis = 3,
           .phi = of_gyros<asymmetry_of_rate>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {0.5, 2, 30, 300},
           .declared = "gyro_asymmetry_sigma_ppm",
           .words = "the gyros' scales differ between turns to the left and to the right",
           .advice = "turn about each axis in both directions"},
    Effect{.name = "accel.cross_terms",
           .needs = need_accel,
           .basis = 15,
           .phi = of_accels<cross_terms>,
           .unit = force_squared,
           .unit_name = "ug/g^2",
           .prior = {2, 10, 50, 1000},
           .declared = "accel_cross_terms_sigma_ug_per_g2",
           .words = "the accelerometers depend on the force across their axes",
           .advice = "add rests with gravity between two axes, and all three"},
    Effect{.name = "accel.hysteresis",
           .needs = need_accel,
           .basis = 3,
           .phi = of_accels<hysteresis>,
           .unit = ug,
           .unit_name = "ug",
           .prior = {1, 5, 50, 500},
           .declared = "accel_hysteresis_sigma_ug",
           .words = "the accelerometers read differently after more force than after less",
           .advice = "come to the same attitude from both sides"},
    Effect{.name = "accel.rectification",
           .needs = need_accel,
           .basis = 3,
           .phi = of_accels<rectification>,
           .unit = force_squared,
           .unit_name = "ug/g^2",
           .prior = {5, 20, 100, 1000},
           .declared = "accel_rectification_sigma_ug_per_g2",
           .words = "vibration shifts the accelerometers' zero",
           .advice = "repeat without the vibration"},
    Effect{.name = "gyro.g_squared",
           .needs = need_gyro,
           .basis = 18,
           .phi = of_gyros<anisoelasticity>,
           .unit = g_squared,
           .unit_name = "deg/h/g^2",
           .prior = {0.0005, 0.002, 0.5, 10},
           .declared = "gyro_g_squared_sigma_deg_per_h_per_g2",
           .words = "the gyros depend on the square of the force",
           .advice = "add rests with gravity between the axes"},
    Effect{.name = "accel.fourth_order",
           .needs = need_accel,
           .basis = 3,
           .phi = of_accels<fourth_order>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {1, 5, 50, 1000},
           .declared = "accel_fourth_order_sigma_ppm",
           .words = "the accelerometers have a term of the fourth order",
           .advice = "add rests with each axis at 30, 45 and 60 deg to gravity"},
    Effect{.name = "gyro.higher_orders",
           .needs = need_gyro,
           .basis = 6,
           .phi = of_gyros<higher_orders>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {1, 5, 50, 1000},
           .declared = "gyro_higher_orders_sigma_ppm",
           .words = "the gyros have terms of the fourth and fifth order",
           .advice = "add turns at several rates"},
    Effect{.name = "gyro.scale_force",
           .needs = need_gyro,
           .basis = 9,
           .phi = of_gyros<force_in_rate>,
           .unit = ppm / g,
           .unit_name = "ppm/g",
           .prior = {0.2, 1, 10, 100},
           .declared = "gyro_scale_force_sigma_ppm_per_g",
           .words = "the gyros' scales depend on the force",
           .advice = "turn about each axis with it up and down"},
    Effect{.name = "accel.heading",
           .needs = need_accel | Effect::by_north,
           .basis = 6,
           .phi = of_accels<along_horizontal>,
           .unit = ug,
           .unit_name = "ug",
           .prior = {1, 5, 200, 1000},
           .declared = "accel_heading_sigma_ug",
           .words = "the accelerometers' offsets follow the heading",
           .advice = "repeat an attitude under several headings, far from iron and magnets"},
    Effect{.name = "gyro.heading",
           .needs = need_gyro | Effect::by_north,
           .basis = 6,
           .phi = of_gyros<along_horizontal>,
           .unit = deg_per_h,
           .unit_name = "deg/h",
           .prior = {0.0001, 0.0007, 0.2, 20},
           .declared = "gyro_heading_sigma_deg_per_h",
           .words = "the gyros' offsets follow the heading",
           .advice = "repeat an attitude under several headings, far from iron and magnets"},
    Effect{.name = "accel.drift",
           .needs = need_accel,
           .basis = 6,
           .phi = of_accels<offset_drift>,
           .unit = ug,
           .unit_name = "ug",
           .prior = {1, 5, 50, 2000},
           .declared = "accel_drift_sigma_ug",
           .words = "the accelerometers' offsets drifted",
           .advice = "repeat the first attitudes at the end",
           .each = Effect::Each::recording},
    Effect{.name = "gyro.drift",
           .needs = need_gyro,
           .basis = 6,
           .phi = of_gyros<offset_drift>,
           .unit = deg_per_h,
           .unit_name = "deg/h",
           .prior = {0.0005, 0.003, 0.5, 150},
           .declared = "gyro_drift_sigma_deg_per_h",
           .words = "the gyros' offsets drifted",
           .advice = "repeat the first attitudes at the end",
           .each = Effect::Each::recording},
    Effect{.name = "accel.scale_drift",
           .needs = need_accel,
           .basis = 6,
           .phi = of_accels<drift_in_force>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {1, 5, 50, 500},
           .declared = "accel_scale_drift_sigma_ppm",
           .words = "the accelerometers' scales drifted",
           .advice = "repeat the first attitudes at the end",
           .each = Effect::Each::recording},
    Effect{.name = "gyro.scale_drift",
           .needs = need_gyro,
           .basis = 6,
           .phi = of_gyros<drift_in_rate>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {1, 5, 50, 500},
           .declared = "gyro_scale_drift_sigma_ppm",
           .words = "the gyros' scales drifted",
           .advice = "repeat the first turns at the end",
           .each = Effect::Each::recording},
    Effect{.name = "accel.offset_temperature",
           .needs = need_accel | Effect::by_thermometer,
           .basis = 3,
           .phi = of_accels<warming>,
           .unit = ug,
           .unit_name = "ug/K",
           .prior = {0.5, 2, 20, 200},
           .declared = "accel_offset_temperature_sigma_ug_per_K",
           .words = "the accelerometers' offsets follow the temperature",
           .advice = "keep the temperature, or use a chamber"},
    Effect{.name = "gyro.offset_temperature",
           .needs = need_gyro | Effect::by_thermometer,
           .basis = 3,
           .phi = of_gyros<warming>,
           .unit = deg_per_h,
           .unit_name = "deg/h/K",
           .prior = {0.0002, 0.001, 0.2, 40},
           .declared = "gyro_offset_temperature_sigma_deg_per_h_per_K",
           .words = "the gyros' offsets follow the temperature",
           .advice = "keep the temperature, or use a chamber"},
    Effect{.name = "accel.scale_temperature",
           .needs = need_accel | Effect::by_thermometer,
           .basis = 3,
           .phi = of_accels<warming_in_force>,
           .unit = ppm,
           .unit_name = "ppm/K",
           .prior = {1, 3, 20, 250},
           .declared = "accel_scale_temperature_sigma_ppm_per_K",
           .words = "the accelerometers' scales follow the temperature",
           .advice = "keep the temperature, or use a chamber"},
    Effect{.name = "gyro.scale_temperature",
           .needs = need_gyro | Effect::by_thermometer,
           .basis = 3,
           .phi = of_gyros<warming_in_rate>,
           .unit = ppm,
           .unit_name = "ppm/K",
           .prior = {0.2, 1, 20, 300},
           .declared = "gyro_scale_temperature_sigma_ppm_per_K",
           .words = "the gyros' scales follow the temperature",
           .advice = "keep the temperature, or use a chamber"},
    Effect{.name = "thermometer.offset",
           .needs = need_accel | need_gyro | Effect::by_thermal,
           .basis = 2,
           .phi = thermometer_error,
           .unit = 1,
           .unit_name = "K",
           .prior = {0.3, 0.3, 0.3, 0.3},
           .declared = "thermometer_offset_sigma_K",
           .words = "a thermometer reads too much or too little in a recording",
           .advice = "wait until the IMU has the temperature of its surroundings",
           .each = Effect::Each::recording},
    Effect{.name = "accel.turn_on",
           .needs = need_accel | Effect::by_recordings,
           .basis = 3,
           .phi = of_accels<turn_on>,
           .unit = ug,
           .unit_name = "ug",
           .prior = {5, 25, 1000, 5000},
           .declared = "accel_turn_on_sigma_ug",
           .words = "the accelerometers' offsets changed between recordings",
           .advice = "repeat an attitude in every recording"},
    Effect{.name = "gyro.turn_on",
           .needs = need_gyro | Effect::by_recordings,
           .basis = 3,
           .phi = of_gyros<turn_on>,
           .unit = deg_per_h,
           .unit_name = "deg/h",
           .prior = {0.0005, 0.0035, 1, 100},
           .declared = "gyro_turn_on_sigma_deg_per_h",
           .words = "the gyros' offsets changed between recordings",
           .advice = "repeat an attitude in every recording"},
    Effect{.name = "mount.elastic",
           .needs = need_accel | need_gyro | Effect::by_mount,
           .basis = 9,
           .phi = elastic_mount,
           .unit = arcsec / g,
           .unit_name = "arcsec/g",
           .prior = {0.5, 1, 5, 30},
           .declared = "mount_elastic_sigma_arcsec_per_g",
           .words = "the IMU bends in its mount under its weight",
           .advice = "turn the IMU in its mount, and repeat"},
    Effect{.name = "mount.change",
           .needs = need_accel | need_gyro | Effect::by_mount | Effect::by_change,
           .basis = 3,
           .phi = change_of_mount,
           .unit = arcsec,
           .unit_name = "arcsec",
           .prior = {30, 30, 30, 60},
           .declared = "mount_change_sigma_arcsec",
           .words = "the IMU moved in its mount",
           .advice = "fasten the IMU, and repeat"},
    Effect{.name = "accel.change",
           .needs = need_accel | Effect::by_change,
           .basis = 3,
           .phi = of_accels<changed>,
           .unit = ug,
           .unit_name = "ug",
           .prior = {5, 25, 1000, 5000},
           .declared = "accel_change_sigma_ug",
           .words = "the accelerometers' offsets changed",
           .advice = "repeat; use the parts before and after by themselves"},
    Effect{.name = "gyro.change",
           .needs = need_gyro | Effect::by_change,
           .basis = 3,
           .phi = of_gyros<changed>,
           .unit = deg_per_h,
           .unit_name = "deg/h",
           .prior = {0.0005, 0.0035, 1, 100},
           .declared = "gyro_change_sigma_deg_per_h",
           .words = "the gyros' offsets changed",
           .advice = "repeat; use the parts before and after by themselves"},
    Effect{.name = "accel.scale_change",
           .needs = need_accel | Effect::by_change,
           .basis = 3,
           .phi = of_accels<changed_in_force>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {5, 20, 150, 1000},
           .declared = "accel_scale_change_sigma_ppm",
           .words = "the accelerometers' scales changed",
           .advice = "repeat; use the parts before and after by themselves"},
    Effect{.name = "gyro.scale_change",
           .needs = need_gyro | Effect::by_change,
           .basis = 3,
           .phi = of_gyros<changed_in_rate>,
           .unit = ppm,
           .unit_name = "ppm",
           .prior = {5, 20, 150, 1000},
           .declared = "gyro_scale_change_sigma_ppm",
           .words = "the gyros' scales changed",
           .advice = "repeat; use the parts before and after by themselves"},
    Effect{.name = "centrifuge.arm",
           .needs = need_accel | Effect::by_centrifuge,
           .basis = 1,
           .phi = longer_arm,
           .unit = 1e-3,
           .unit_name = "mm",
           .prior = {0.2, 0.2, 0.2, 0.2},
           .declared = "centrifuge_arm_sigma_mm",
           .words = "the centrifuge's arm grows longer with its rate",
           .advice = "measure the arm's growth, or use more rates"},
    Effect{.name = "site.latitude",
           .needs = need_accel | need_gyro | Effect::by_latitude,
           .basis = 1,
           .phi = farther_north,
           .unit = deg,
           .unit_name = "deg",
           .prior = {0.05, 0.05, 0.05, 0.05},
           .declared = "site_latitude_sigma_deg",
           .words = "the latitude is not the declared one",
           .advice = "check the site's latitude and its sign"},
    Effect{.name = "site.north",
           .needs = need_gyro | Effect::by_latitude | Effect::by_mount,
           .basis = 1,
           .phi = turned_about_up,
           .unit = deg,
           .unit_name = "deg",
           .prior = {1, 1, 1, 1},
           .declared = "site_north_sigma_deg",
           .words = "a machine's zero angle is not north",
           .advice = "measure the machine's heading",
           .each = Effect::Each::machine},
};

}  // namespace

std::span<const Effect> effects() { return table; }

}  // namespace imulab
