// PX4: parameters as QGroundControl loads them (PX4/PX4-Autopilot: src/lib/sensor_calibration/Accelerometer.hpp, Gyroscope.hpp,
// src/modules/temperature_compensation; the form of the lines as in Tools/process_sensor_caldata.py).
#include "imulab/io/export/autopilot.hpp"
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/io/export/targets.hpp"
#include "imulab/io/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

std::string px4_line(const std::string& name, double value) { return fmt::format("1\t1\t{}\t{}\t9\n", name, float_text(value)); }

/// TC_A0_... or TC_G0_...: about the calibration's own reference, where the drift is zero.
std::string px4_thermal(const TriadModel& m, const std::string& group, int instance) {
  if (!celsius_drift(m, 0)) return {};
  const double about = celsius_drift(m, 0)->reference;
  const CelsiusDrift drift = *celsius_drift(m, about);
  const std::string name = fmt::format("{}{}_", group, instance);
  std::string text = fmt::format("1\t1\t{}_ENABLE\t1\t6\n", group) + px4_line(name + "TREF", about) + px4_line(name + "TMIN", drift.range[0]) +
                     px4_line(name + "TMAX", drift.range[1]);
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<double, 4> c{drift.c0[axis], drift.c1[axis], drift.c2[axis], 0};
    for (std::size_t power = 4; power-- > 0;) text += px4_line(fmt::format("{}X{}_{}", name, power, axis), c[power]);
  }
  return text;
}

void px4_thermal_fact(Sentences& facts, const TriadModel& m, const char* what, std::string (*size)(double)) {
  const auto drift = celsius_drift(m, 0);
  if (!drift) return;
  const double error = single_precision_error(*celsius_drift(m, drift->reference), drift->reference);
  facts.push_back(
      fmt::format("{} thermal offsets: the polynomial is the calibration's own, of second order; in single precision within {} over {:g} to "
                  "{:g} degC. Outside PX4 keeps the offset of the nearer end.",
                  what, size(error), drift->range[0], drift->range[1]));
}

}  // namespace

std::string px4_text(const ExportInput& input) {
  const SensorModel& model = input.calibration.model;
  expect_si_readings(model);
  const ConsumerModel m = consumer_model(model);
  const int i = input.options.instance;
  Sentences facts{
      "a = (a_raw - thermal offset - OFF) * SCALE      w = w_raw - thermal offset - OFF",
      "so offsets are subtracted from readings [m/s^2, rad/s], in the sensor's frame; the board's rotation comes after. SCALE is the diagonal of the",
      "correction matrix. Gyros have no scale. Readings are along x, y, z of the calibration, which must be the driver's.",
      fmt::format(
          "CAL_ACC{0}_ID and CAL_GYRO{0}_ID (with temperature also TC_A{0}_ID, TC_G{0}_ID) must hold the sensors' device ids: not written here.", i),
      "Parameters are in single precision. Some versions of PX4 ignore changes of offset or scale below 0.01 (m/s^2; 1)."};
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
  for (int axis = 0; axis < 3; ++axis)
    warn_outside(out, fmt::format("CAL_ACC{}_{}SCALE", input.options.instance, "XYZ"[axis]), input.calibration.model.accel.matrix(axis, axis), 0.1, 3,
                 "PX4");
  return out;
}

}  // namespace imulab::export_io
