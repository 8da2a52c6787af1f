// PX4: parameters as QGroundControl loads them (PX4/PX4-Autopilot: src/lib/sensor_calibration/Accelerometer.hpp, Gyroscope.hpp,
// src/modules/temperature_compensation; the form of the lines as in Tools/process_sensor_caldata.py).
#include "imulab/export/autopilot.hpp"
#include "imulab/export/device_axes.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

std::string px4_line(const std::string& name, double value) { return fmt::format("1\t1\t{}\t{}\t9\n", name, float_text(value)); }

/// TC_A0_... or TC_G0_...: about the calibration's own reference, where the drift is zero.
std::string px4_thermal(const TriadModel& m, const std::string& group, int instance) {
  if (!celsius_drift(m, 0)) return fmt::format("1\t1\t{}_ENABLE\t0\t6\n", group);  // that of an earlier calibration would be added
  const double about = celsius_drift(m, 0)->reference;
  const CelsiusDrift drift = *celsius_drift(m, about);
  const std::string name = fmt::format("{}{}_", group, instance);
  std::string text = fmt::format("1\t1\t{}_ENABLE\t1\t6\n", group) + px4_line(name + "TREF", about) + px4_line(name + "TMIN", drift.range[0]) +
                     px4_line(name + "TMAX", drift.range[1]);
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<double, 4> c{drift.c0[axis], drift.c1[axis], drift.c2[axis], drift.c3[axis]};
    for (std::size_t power = 4; power-- > 0;) text += px4_line(fmt::format("{}X{}_{}", name, power, axis), c[power]);
  }
  return text;
}

void px4_thermal_fact(Sentences& facts, const TriadModel& m, const char* what, std::string (*size)(double)) {
  const auto drift = celsius_drift(m, 0);
  if (!drift) return;
  const double about = drift->reference;
  const CelsiusDrift own = *celsius_drift(m, about);
  // TemperatureCompensation.cpp: a new offset once the temperature has changed by more than 1 degC
  const double lag = steepest_drift(own, about, m.matrix.diagonal()) + single_precision_error(own, about);
  facts.push_back(fmt::format("{} thermal offsets: the polynomial is the calibration's own over {:g} to {:g} degC; outside PX4 keeps", what,
                              drift->range[0], drift->range[1]));
  facts.push_back(
      fmt::format("that of the nearer end. PX4 sets them anew only when the temperature has changed by more than 1 degC: within {}.", size(lag)));
}

}  // namespace

std::string px4_text(const ExportInput& input) {
  expect_si_readings(input.calibration.model);
  const SensorModel model = along_device_axes(input.calibration.model, device_axes(input.calibration));
  const ConsumerModel m = consumer_model(model);
  const int i = input.options.instance;
  Sentences facts{
      "Holds: accelerometers' offsets and scales, gyros' offsets, thermal offsets of both in degC.",
      "a = (a_raw - thermal offset - OFF) * SCALE      w = w_raw - thermal offset - OFF",
      "so offsets are subtracted from readings [m/s^2, rad/s], in the sensor's frame; the board's rotation comes after. SCALE is the diagonal of the",
      "correction matrix. Gyros have no scale.",
      fmt::format(
          "CAL_ACC{0}_ID and CAL_GYRO{0}_ID (with temperature also TC_A{0}_ID, TC_G{0}_ID) must hold the sensors' device ids: not written here.", i),
      "Parameters are in single precision. Some versions of PX4 ignore changes of offset or scale below 0.01 (m/s^2; 1).",
      "PX4 learns offsets anew and stores them over these: of the gyros at rest with IMU_GYRO_CAL_EN 1, of all from the estimator with "
      "SENS_IMU_AUTOCAL 1.",
      "Set both to 0 to keep this calibration. TC_A_ENABLE and TC_G_ENABLE are for all instances; 0 where this calibration has no thermal offsets."};
  const Sentences axes = autopilot_axes_facts(input.calibration);
  facts.insert(facts.end(), axes.begin(), axes.end());
  px4_thermal_fact(facts, model.accel, "Accelerometers'", accel_size);
  px4_thermal_fact(facts, model.gyro, "Gyros'", gyro_size);
  std::string text = comment_head(input, "PX4", facts, left_out_of_px4(input)) + "# Vehicle-Id Component-Id Name Value Type\n";
  for (int axis = 0; axis < 3; ++axis) text += px4_line(fmt::format("CAL_ACC{}_{}OFF", i, "XYZ"[axis]), m.accel.b[axis]);
  for (int axis = 0; axis < 3; ++axis) text += px4_line(fmt::format("CAL_ACC{}_{}SCALE", i, "XYZ"[axis]), m.accel.C(axis, axis));
  for (int axis = 0; axis < 3; ++axis) text += px4_line(fmt::format("CAL_GYRO{}_{}OFF", i, "XYZ"[axis]), m.gyro.b[axis]);
  return text + px4_thermal(model.accel, "TC_A", i) + px4_thermal(model.gyro, "TC_G", i);
}

Sentences left_out_of_px4(const ExportInput& input) { return losses(input.calibration.model, autopilot_holds(input.calibration.model)); }

Sentences px4_warnings(const ExportInput& input) {
  Sentences out;
  warn_different_axes(out, input.calibration);
  const SensorModel model = along_device_axes(input.calibration.model, device_axes(input.calibration));
  for (int axis = 0; axis < 3; ++axis)
    warn_outside(out, fmt::format("CAL_ACC{}_{}SCALE", input.options.instance, "XYZ"[axis]), model.accel.matrix(axis, axis), 0.1, 3, "PX4");
  return out;
}

}  // namespace imulab::export_io
