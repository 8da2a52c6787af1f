#include "imulab/export/autopilot.hpp"

#include "imulab/export/device_axes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::export_io {

std::optional<CelsiusDrift> celsius_drift(const TriadModel& m, double about) {
  if (m.thermal.isZero(0) || !m.temperature || (m.temperature->unit != "degC" && m.temperature->unit != "K")) return std::nullopt;
  if (!(m.temperature->range[1] > m.temperature->range[0])) return std::nullopt;
  const double zero = m.temperature->unit == "K" ? 273.15 : 0;
  CelsiusDrift out{{m.temperature->range[0] - zero, m.temperature->range[1] - zero}, m.temperature->reference - zero, {}, {}, {}};
  // c1 tau + c2 tau^2 with tau = d + e
  const double e = about - out.reference;
  const Vector3d c1 = m.thermal.col(1), c2 = m.thermal.col(2);
  out.c0 = c1 * e + c2 * e * e;
  out.c1 = c1 + 2 * e * c2;
  out.c2 = c2;
  return out;
}

Held autopilot_holds(const SensorModel& model) {
  Held held{.accel_scale = true, .bias = true};
  held.accel_thermal = celsius_drift(model.accel, 0).has_value();
  held.gyro_thermal = celsius_drift(model.gyro, 0).has_value();
  return held;
}

double single_precision_error(const CelsiusDrift& drift, double about) {
  constexpr int steps = 1000;
  double most = 0;
  for (int i = 0; i <= steps; ++i) {
    const double d = drift.range[0] + (drift.range[1] - drift.range[0]) * i / steps - about;
    const auto single = static_cast<float>(d);
    for (int axis = 0; axis < 3; ++axis) {
      const float c0 = static_cast<float>(drift.c0[axis]), c1 = static_cast<float>(drift.c1[axis]), c2 = static_cast<float>(drift.c2[axis]);
      const float inexact = c0 + (c1 + c2 * single) * single;
      most = std::max(most, std::abs(static_cast<double>(inexact) - (drift.c0[axis] + (drift.c1[axis] + drift.c2[axis] * d) * d)));
    }
  }
  return most;
}

double steepest_drift(const CelsiusDrift& drift, double about, const Vector3d& scale) {
  double most = 0;
  for (const double T : drift.range)  // the slope is linear: steepest at an end
    most = std::max(most, scale.cwiseProduct(drift.c1 + 2 * (T - about) * drift.c2).cwiseAbs().maxCoeff());
  return most;
}

std::vector<std::string> autopilot_axes_facts(const Calibration& calibration) {
  std::vector<std::string> out = input_facts(calibration);
  out.emplace_back("Parameters are along these axes of the device, which must be the driver's before the board's rotation; outputs likewise.");
  return out;
}

void warn_different_axes(std::vector<std::string>& warnings, const Calibration& calibration) {
  const DeviceAxes axes = device_axes(calibration);
  if (axes.accel == axes.gyro) return;
  warnings.emplace_back(
      "accelerometers and gyros were recorded along different axes, and an autopilot turns both alike: its driver must give them along the same "
      "axes");
}

void warn_outside(std::vector<std::string>& warnings, const std::string& parameter, double value, double low, double high, const char* program) {
  if (value >= low && value <= high) return;
  warnings.push_back(fmt::format("{} is {:.6g}: outside {:g} to {:g}, which {} accepts", parameter, value, low, high, program));
}

}  // namespace imulab::export_io
