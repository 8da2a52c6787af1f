// ArduPilot: parameters as ground stations load them (ArduPilot/ardupilot: libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp,
// AP_InertialSensor_tempcal.cpp, AP_InertialSensor.cpp).
#include "imulab/core/error.hpp"
#include "imulab/io/export/autopilot.hpp"
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/io/export/targets.hpp"
#include "imulab/io/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab::export_io {

namespace {

constexpr double tempcal_reference = 35, coefficient_scale = 1e6;  // TEMP_REFERENCE, SCALE_FACTOR of AP_InertialSensor_tempcal.cpp

struct TriadParameters {
  Vector3d offset;
  std::optional<CelsiusDrift> drift;  ///< about tempcal_reference
  double calibrated_at = 0;           ///< degC, where the polynomial adds nothing to the offset
};

struct AutopilotParameters {
  TriadParameters accel, gyro;
  std::optional<std::array<double, 2>> range;  ///< degC, one for both triads: where both have thermal terms, what both were calibrated for
};

/// The polynomial has no constant; its value at the temperature of calibration, which lies within the range, is subtracted.
void set_calibration_temperature(TriadParameters& p, const TriadModel& m, const std::array<double, 2>& range) {
  if (!p.drift) return;
  p.calibrated_at = std::clamp(p.drift->reference, range[0], range[1]);
  p.offset += celsius_drift(m, p.calibrated_at)->c0;
}

AutopilotParameters autopilot_parameters(const SensorModel& model, const ConsumerModel& m) {
  AutopilotParameters p{{m.accel.b, celsius_drift(model.accel, tempcal_reference)}, {m.gyro.b, celsius_drift(model.gyro, tempcal_reference)}, {}};
  for (const TriadParameters* triad : {&p.accel, &p.gyro}) {
    if (!triad->drift) continue;
    const auto& range = triad->drift->range;
    p.range = p.range ? std::array{std::max((*p.range)[0], range[0]), std::min((*p.range)[1], range[1])} : range;
  }
  if (!p.range) return p;
  if (!((*p.range)[1] > (*p.range)[0])) throw Error("the temperature ranges of accelerometers and gyros do not overlap; expected one range for both");
  set_calibration_temperature(p.accel, model.accel, *p.range);
  set_calibration_temperature(p.gyro, model.gyro, *p.range);
  return p;
}

std::string ardupilot_line(const std::string& name, double value) { return fmt::format("{},{}\n", name, float_text(value)); }

std::string ardupilot_xyz(const std::string& name, const Vector3d& v) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += ardupilot_line(fmt::format("{}_{}", name, "XYZ"[axis]), v[axis]);
  return text;
}

std::string tempcal_lines(const TriadParameters& p, const std::string& name) {
  const Vector3d none = Vector3d::Zero(), c1 = p.drift ? p.drift->c1 : none, c2 = p.drift ? p.drift->c2 : none;
  return ardupilot_xyz(name + "1", c1 * coefficient_scale) + ardupilot_xyz(name + "2", c2 * coefficient_scale) + ardupilot_xyz(name + "3", none);
}

std::string ardupilot_name(const char* triad, int instance, const char* tail) {  // INS_ACCOFFS, INS_ACC2OFFS, INS_ACC3OFFS
  return fmt::format("INS_{}{}{}", triad, instance == 0 ? "" : std::to_string(instance + 1), tail);
}

void tempcal_fact(Sentences& facts, const TriadParameters& p, const char* what, std::string (*size)(double)) {
  if (!p.drift) return;
  facts.push_back(fmt::format("{} thermal offsets: the polynomial is the calibration's own, of second order; in single precision within {}.", what,
                              size(single_precision_error(*p.drift, tempcal_reference))));
}

}  // namespace

std::string ardupilot_text(const ExportInput& input) {
  const SensorModel& model = input.calibration.model;
  expect_si_readings(model);
  const ConsumerModel m = consumer_model(model);
  const int i = input.options.instance;
  const AutopilotParameters p = autopilot_parameters(model, m);
  const TriadParameters &a = p.accel, &g = p.gyro;
  Sentences facts{
      "a = (a_raw - P(T) + P(CALTEMP) - OFFS) * SCAL      w = w_raw - P(T) + P(CALTEMP) - OFFS      P(T) = 1e-6 (c1 d + c2 d^2 + c3 d^3), d = T - 35 "
      "degC",
      "so offsets are subtracted from readings [m/s^2, rad/s], after the sensor's and before the board's rotation. SCAL is the diagonal of the",
      "correction matrix. Gyros have no scale. Readings are along x, y, z of the calibration, which must be the driver's.",
      "The gyros' offsets are measured anew at each boot unless INS_GYR_CAL is 0. Parameters are in single precision."};
  tempcal_fact(facts, a, "Accelerometers'", accel_size);
  tempcal_fact(facts, g, "Gyros'", gyro_size);
  std::string text =
      comment_head(input, "ArduPilot", facts, left_out_of_ardupilot(input)) + ardupilot_xyz(ardupilot_name("ACC", i, "OFFS"), a.offset) +
      ardupilot_xyz(ardupilot_name("ACC", i, "SCAL"), m.accel.C.diagonal()) + ardupilot_xyz(ardupilot_name("GYR", i, "OFFS"), g.offset);
  if (!p.range) return text;
  const std::string tcal = fmt::format("INS_TCAL{}_", i + 1);
  text += tcal + "ENABLE,1\n" + ardupilot_line(tcal + "TMIN", (*p.range)[0]) + ardupilot_line(tcal + "TMAX", (*p.range)[1]);
  if (a.drift) text += ardupilot_line(fmt::format("INS_ACC{}_CALTEMP", i + 1), a.calibrated_at);
  if (g.drift) text += ardupilot_line(fmt::format("INS_GYR{}_CALTEMP", i + 1), g.calibrated_at);
  return text + tempcal_lines(a, tcal + "ACC") + tempcal_lines(g, tcal + "GYR");
}

Sentences left_out_of_ardupilot(const ExportInput& input) { return losses(input.calibration.model, autopilot_holds(input.calibration.model)); }

Sentences ardupilot_warnings(const ExportInput& input) {
  const ConsumerModel m = consumer_model(input.calibration.model);
  const TriadParameters a = autopilot_parameters(input.calibration.model, m).accel;
  Sentences out;
  for (int axis = 0; axis < 3; ++axis) {
    warn_outside(out, fmt::format("{}_{}", ardupilot_name("ACC", input.options.instance, "OFFS"), "XYZ"[axis]), a.offset[axis], -3.5, 3.5,
                 "ArduPilot");
    warn_outside(out, fmt::format("{}_{}", ardupilot_name("ACC", input.options.instance, "SCAL"), "XYZ"[axis]), m.accel.C(axis, axis), 0.8, 1.2,
                 "ArduPilot");
  }
  return out;
}

}  // namespace imulab::export_io
