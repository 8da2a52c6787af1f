#include "imulab/export/device_axes.hpp"

#include "imulab/error.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <string_view>
#include <tuple>

namespace imulab::export_io {

namespace {

Matrix3d axes_matrix(const std::optional<RecordedAs>& recorded) {
  if (!recorded) return Matrix3d::Identity();
  Matrix3d P = Matrix3d::Zero();
  for (int column = 0; column < 3; ++column) {
    const std::string& axis = recorded->axes[static_cast<std::size_t>(column)];
    const std::size_t body = axis.size() == 2 && (axis[0] == '+' || axis[0] == '-') ? std::string_view("xyz").find(axis[1]) : std::string::npos;
    if (body == std::string::npos || !P.row(static_cast<int>(body)).isZero(0))
      throw Error(fmt::format("recorded: axis {} of column {}; expected +x, -x, +y, -y, +z or -z, each axis once", plain(axis), column + 1));
    P(static_cast<int>(body), column) = axis[0] == '-' ? -1 : 1;
  }
  return P;
}

ConsumerTriad turned_triad(const ConsumerTriad& t, const Matrix3d& P) { return {t.C * P, P.transpose() * t.T, P.transpose() * t.b}; }

TriadModel turned_model(const TriadModel& m, const Matrix3d& P) {
  TriadModel out = m;
  out.offset = P.transpose() * m.offset;
  out.matrix = P.transpose() * m.matrix * P;
  out.quadratic = P.transpose() * m.quadratic;  // of V^2, which has no sign
  out.cubic = P.cwiseAbs().transpose() * m.cubic;
  out.thermal = P.transpose() * m.thermal;
  out.matrix_thermal1 = P.transpose() * m.matrix_thermal1 * P;
  out.matrix_thermal2 = P.transpose() * m.matrix_thermal2 * P;
  return out;
}

}  // namespace

DeviceAxes device_axes(const Calibration& calibration) { return {axes_matrix(calibration.recorded_accel), axes_matrix(calibration.recorded_gyro)}; }

ConsumerModel device_model(const SensorModel& model, const DeviceAxes& axes) {
  const ConsumerModel m = consumer_model(model);
  return {turned_triad(m.accel, axes.accel), turned_triad(m.gyro, axes.gyro), axes.gyro.transpose() * m.G};
}

SensorModel along_device_axes(const SensorModel& model, const DeviceAxes& axes) {
  SensorModel out = model;
  out.accel = turned_model(model.accel, axes.accel);
  out.gyro = turned_model(model.gyro, axes.gyro);
  out.g_sensitivity = axes.gyro.transpose() * model.g_sensitivity * axes.accel;
  return out;
}

std::vector<std::string> input_facts(const Calibration& c) {
  std::vector<std::string> out;
  for (const auto& [recorded, name, si] :
       {std::tuple{&c.recorded_accel, "accelerometers", "m/s^2"}, std::tuple{&c.recorded_gyro, "gyros", "rad/s"}}) {
    if (!*recorded) {
      out.push_back(fmt::format("Input: {} in {} along x, y, z of the body: the calibration does not know the device's axes.", name, si));
      continue;
    }
    const RecordedAs& as = **recorded;
    std::string text = fmt::format("Input: {} in {}, the device's x, y, z along {}, {}, {} of the body", name, si, plain(as.axes[0]),
                                   plain(as.axes[1]), plain(as.axes[2]));
    if (as.unit != si || as.counts_per_unit != 1 || as.interval_s > 0)
      text +=
          fmt::format("; the recording had {}{}{}: convert", as.counts_per_unit != 1 ? fmt::format("{:g} counts to one ", as.counts_per_unit) : "",
                      plain(as.unit), as.interval_s > 0 ? fmt::format(" over {:g} s", as.interval_s) : "");
    out.push_back(text + ".");
  }
  return out;
}

}  // namespace imulab::export_io
