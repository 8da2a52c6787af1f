// ArduPilot: parameters as ground stations load them (ArduPilot/ardupilot: libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp,
// AP_InertialSensor_tempcal.cpp, AP_InertialSensor.cpp).
#include "imulab/error.hpp"
#include "imulab/export/autopilot.hpp"
#include "imulab/export/device_axes.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

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

/// The part of this triad's drift that the one range of both triads leaves uncorrected, in the output: beyond it ArduPilot keeps the drift of the
/// nearer end.
double drift_outside(const CelsiusDrift& drift, const Matrix3d& correction, const std::array<double, 2>& range) {
  constexpr int steps = 100;
  const auto at = [&](double T) {
    const double d = T - tempcal_reference;
    return Vector3d(drift.c1 * d + drift.c2 * (d * d) + drift.c3 * (d * d * d));
  };
  double most = 0;
  for (int i = 0; i <= steps; ++i) {
    const double T = drift.range[0] + (drift.range[1] - drift.range[0]) * i / steps;
    most = std::max(most, (correction * (at(T) - at(std::clamp(T, range[0], range[1])))).cwiseAbs().maxCoeff());
  }
  return most;
}

Sentences drifts_outside(const SensorModel& model) {
  Sentences out;
  const AutopilotParameters p = autopilot_parameters(model, consumer_model(model));
  for (const auto& [triad, m, name, size] :
       {std::tuple{&p.accel, &model.accel, "accelerometers'", &accel_size}, std::tuple{&p.gyro, &model.gyro, "gyros'", &gyro_size}}) {
    if (!triad->drift) continue;
    const double lost = drift_outside(*triad->drift, m->matrix, *p.range);
    if (lost > 0)
      out.push_back(fmt::format("{} thermal terms outside {:g} to {:g} degC, one range for both triads: up to {} over {:g} to {:g} degC", name,
                                (*p.range)[0], (*p.range)[1], size(lost), triad->drift->range[0], triad->drift->range[1]));
  }
  return out;
}

/// INS_ACCOFFS, INS_ACC2OFFS, INS_ACC3OFFS: those are all.
void expect_instance(int instance) {
  if (instance < 0 || instance > 2) throw Error(fmt::format("instance {}: ArduPilot has parameters for three; expected 0, 1 or 2", instance));
}

std::string ardupilot_line(const std::string& name, double value) { return fmt::format("{},{}\n", name, float_text(value)); }

std::string ardupilot_xyz(const std::string& name, const Vector3d& v) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += ardupilot_line(fmt::format("{}_{}", name, "XYZ"[axis]), v[axis]);
  return text;
}

std::string tempcal_lines(const TriadParameters& p, const std::string& name) {
  const Vector3d none = Vector3d::Zero();
  const auto line = [&](const char* order, const Vector3d CelsiusDrift::*c) {
    return ardupilot_xyz(name + order, p.drift ? Vector3d((*p.drift).*c * coefficient_scale) : none);
  };
  return line("1", &CelsiusDrift::c1) + line("2", &CelsiusDrift::c2) + line("3", &CelsiusDrift::c3);
}

std::string ardupilot_name(const char* triad, int instance, const char* tail) {  // INS_ACCOFFS, INS_ACC2OFFS, INS_ACC3OFFS
  return fmt::format("INS_{}{}{}", triad, instance == 0 ? "" : std::to_string(instance + 1), tail);
}

void tempcal_fact(Sentences& facts, const TriadParameters& p, const char* what, std::string (*size)(double)) {
  if (!p.drift) return;
  facts.push_back(fmt::format("{} thermal offsets: the polynomial is the calibration's own; in single precision within {}.", what,
                              size(single_precision_error(*p.drift, tempcal_reference))));
}

/// ArduPilot reads a file in pieces of 98 characters (AP_Param::read_param_defaults_file) and would take the rest of a longer comment for a
/// parameter.
std::string with_short_comments(const std::string& text) {
  constexpr std::size_t longest = 97;
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    while (line.size() > longest && line.starts_with('#')) {
      const std::size_t blank = line.rfind(' ', longest);
      const std::size_t end = blank != std::string::npos && blank > longest / 2 ? blank : longest;
      const std::size_t last = line.find_last_not_of(' ', end - 1);
      out += line.substr(0, last + 1) + "\n";
      line = "#   " + line.substr(line.find_first_not_of(' ', end));
    }
    out += line + "\n";
  }
  return out;
}

}  // namespace

std::string ardupilot_text(const ExportInput& input) {
  expect_si_readings(input.calibration.model);
  expect_instance(input.options.instance);
  const SensorModel model = along_device_axes(input.calibration.model, device_axes(input.calibration));
  const ConsumerModel m = consumer_model(model);
  const int i = input.options.instance;
  const AutopilotParameters p = autopilot_parameters(model, m);
  const TriadParameters &a = p.accel, &g = p.gyro;
  Sentences facts{
      "Holds: accelerometers' offsets and scales, gyros' offsets, thermal offsets of both in degC over one range.",
      "a = (a_raw - P(T) + P(CALTEMP) - OFFS) * SCAL      w = w_raw - P(T) + P(CALTEMP) - OFFS      P(T) = 1e-6 (c1 d + c2 d^2 + c3 d^3), d = T - 35 "
      "degC",
      "so offsets are subtracted from readings [m/s^2, rad/s], after the sensor's and before the board's rotation. SCAL is the diagonal of the",
      "correction matrix. Gyros have no scale.",
      "The gyros' offsets are measured anew at each boot unless INS_GYR_CAL is 0. Parameters are in single precision.",
      fmt::format("{} and {} must hold the sensors' device ids, else ArduPilot takes the IMU as not calibrated: not written here.",
                  ardupilot_name("ACC", i, "_ID"), ardupilot_name("GYR", i, "_ID"))};
  const Sentences axes = autopilot_axes_facts(input.calibration);
  facts.insert(facts.end(), axes.begin(), axes.end());
  tempcal_fact(facts, a, "Accelerometers'", accel_size);
  tempcal_fact(facts, g, "Gyros'", gyro_size);
  std::string text = with_short_comments(comment_head(input, "ArduPilot", facts, left_out_of_ardupilot(input))) +
                     ardupilot_xyz(ardupilot_name("ACC", i, "OFFS"), a.offset) +
                     ardupilot_xyz(ardupilot_name("ACC", i, "SCAL"), m.accel.C.diagonal()) +
                     ardupilot_xyz(ardupilot_name("GYR", i, "OFFS"), g.offset);
  const std::string tcal = fmt::format("INS_TCAL{}_", i + 1);
  if (!p.range) return text + tcal + "ENABLE,0\n";  // the polynomial of an earlier calibration would be subtracted
  text += tcal + "ENABLE,1\n" + ardupilot_line(tcal + "TMIN", (*p.range)[0]) + ardupilot_line(tcal + "TMAX", (*p.range)[1]);
  if (a.drift) text += ardupilot_line(fmt::format("INS_ACC{}_CALTEMP", i + 1), a.calibrated_at);
  if (g.drift) text += ardupilot_line(fmt::format("INS_GYR{}_CALTEMP", i + 1), g.calibrated_at);
  return text + tempcal_lines(a, tcal + "ACC") + tempcal_lines(g, tcal + "GYR");
}

Sentences left_out_of_ardupilot(const ExportInput& input) {
  const SensorModel& model = input.calibration.model;
  Sentences out = losses(model, autopilot_holds(model));
  const Sentences outside = drifts_outside(model);
  out.insert(out.end(), outside.begin(), outside.end());
  return out;
}

Sentences ardupilot_warnings(const ExportInput& input) {
  const SensorModel model = along_device_axes(input.calibration.model, device_axes(input.calibration));
  const ConsumerModel m = consumer_model(model);
  const AutopilotParameters p = autopilot_parameters(model, m);
  const TriadParameters& a = p.accel;
  Sentences out;
  warn_different_axes(out, input.calibration);
  const std::string tcal = fmt::format("INS_TCAL{}_", input.options.instance + 1);
  if (p.range) {
    warn_outside(out, tcal + "TMIN", (*p.range)[0], -70, 80, "ArduPilot");
    warn_outside(out, tcal + "TMAX", (*p.range)[1], -70, 80, "ArduPilot");
  }
  for (int axis = 0; axis < 3; ++axis) {
    warn_outside(out, fmt::format("{}_{}", ardupilot_name("ACC", input.options.instance, "OFFS"), "XYZ"[axis]), a.offset[axis], -3.5, 3.5,
                 "ArduPilot");
    warn_outside(out, fmt::format("{}_{}", ardupilot_name("ACC", input.options.instance, "SCAL"), "XYZ"[axis]), m.accel.C(axis, axis), 0.8, 1.2,
                 "ArduPilot");
  }
  return out;
}

}  // namespace imulab::export_io
