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
  CelsiusDrift out{{m.temperature->range[0] - zero, m.temperature->range[1] - zero}, m.temperature->reference - zero, {}, {}, {}, {}};
  // c1 tau + c2 tau^2 + c3 tau^3 with tau = d + e
  const double e = about - out.reference;
  const Vector3d c1 = m.thermal.col(1), c2 = m.thermal.col(2), c3 = m.thermal.col(3);
  out.c0 = m.drift(Vector3d::Constant(e));
  out.c1 = c1 + 2 * e * c2 + 3 * e * e * c3;
  out.c2 = c2 + 3 * e * c3;
  out.c3 = c3;
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
      const float c0 = static_cast<float>(drift.c0[axis]), c1 = static_cast<float>(drift.c1[axis]), c2 = static_cast<float>(drift.c2[axis]),
                  c3 = static_cast<float>(drift.c3[axis]);
      const float inexact = c0 + (c1 + (c2 + c3 * single) * single) * single;
      const double exact = drift.c0[axis] + (drift.c1[axis] + (drift.c2[axis] + drift.c3[axis] * d) * d) * d;
      most = std::max(most, std::abs(static_cast<double>(inexact) - exact));
    }
  }
  return most;
}

double steepest_drift(const CelsiusDrift& drift, double about, const Vector3d& scale) {
  constexpr int steps = 1000;
  double most = 0;
  for (int i = 0; i <= steps; ++i) {
    const double d = drift.range[0] + (drift.range[1] - drift.range[0]) * i / steps - about;
    most = std::max(most, scale.cwiseProduct(drift.c1 + 2 * d * drift.c2 + 3 * d * d * drift.c3).cwiseAbs().maxCoeff());
  }
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
