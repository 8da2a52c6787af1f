#include "imulab/export/openvins_prior.hpp"

#include "imulab/export/device_axes.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab::export_io {

namespace {

constexpr int state_count = 24;  // vec_dw 6, vec_da 6, vec_tg 9, rotation 3
using OpenVinsStates = Eigen::Matrix<double, state_count, 1>;

void put_triangle(const Matrix3d& D, bool upper, int first, OpenVinsStates& out) {
  int k = first;
  for (int j = 0; j < 3; ++j)
    for (int i = upper ? 0 : j; upper ? i <= j : i < 3; ++i) out[k++] = D(i, j);
}

/// The rotation that OpenVINS estimates, R_GYROtoIMU or R_ACCtoIMU.
Matrix3d estimated_rotation(const OpenVinsModel& v, const std::string& which) { return (which == "rpng" ? v.R_IMUtoACC : v.R_IMUtoGYRO).transpose(); }

/// The states of a model. JPLQuat::update multiplies the correction from the left, R = (1 - [theta x]) R_start, so that the error of R_GYROtoIMU (or
/// R_ACCtoIMU) is a rotation vector in the IMU frame.
OpenVinsStates openvins_states(const SensorModel& model, const DeviceAxes& axes, const std::string& which, const Matrix3d& start) {
  const OpenVinsModel v = openvins_model(device_model(model, axes), which);
  OpenVinsStates out;
  put_triangle(v.Tw.inverse(), which == "rpng", 0, out);
  put_triangle(v.Ta.inverse(), which == "rpng", 6, out);
  for (int k = 0; k < 9; ++k) out[12 + k] = v.Tg(k % 3, k / 3);
  out.tail<3>() = -rotation_log(estimated_rotation(v, which) * start.transpose());
  return out;
}

/// Zero by the choice of the frame, and so exactly known.
bool fixed_by_frame(const Calibration& c, CoefficientIndex index) {
  const Coefficient& k = coefficient(index);
  return c.frame == "accelerometers" && k.triad == Triad::accel && k.term == Term::matrix && k.row < k.column &&
         coefficient_value(c.model, index) == 0;
}

bool is_estimated(const Calibration& c, CoefficientIndex index) {
  const auto& undetermined = c.quality.unobservable;
  return contains(c.estimated, index) && std::find(undetermined.begin(), undetermined.end(), coefficient(index).name) == undetermined.end();
}

/// Standard uncertainties; NaN where a state depends on a coefficient that was not estimated.
OpenVinsStates state_uncertainties(const Calibration& c, const std::string& which) {
  const DeviceAxes axes = device_axes(c);
  const Matrix3d start = estimated_rotation(openvins_model(device_model(c.model, axes), which), which);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(state_count, static_cast<Eigen::Index>(c.estimated.size()));
  OpenVinsStates unknown = OpenVinsStates::Zero();
  for (const CoefficientIndex index : select_each({"accel.matrix", "gyro.matrix", "gyro.g_sensitivity"})) {
    // Central differences, with a step that rounding and curvature allow for coefficients near one.
    constexpr double step = 1e-6, rounding = 1e-8;
    SensorModel more = c.model, less = c.model;
    set_coefficient(more, index, coefficient_value(more, index) + step);
    set_coefficient(less, index, coefficient_value(less, index) - step);
    const OpenVinsStates slope = (openvins_states(more, axes, which, start) - openvins_states(less, axes, which, start)) / (2 * step);
    if (is_estimated(c, index))
      jacobian.col(std::find(c.estimated.begin(), c.estimated.end(), index) - c.estimated.begin()) = slope;
    else if (!fixed_by_frame(c, index))
      unknown = unknown.cwiseMax((slope.array().abs() > rounding).cast<double>().matrix());
  }
  OpenVinsStates sigma = (jacobian * c.covariance * jacobian.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  for (int k = 0; k < state_count; ++k)
    if (unknown[k] != 0) sigma[k] = std::numeric_limits<double>::quiet_NaN();
  return sigma;
}

}  // namespace

std::vector<std::string> openvins_prior(const Calibration& calibration, const std::string& model) {
  if (calibration.estimated.empty()) return {"Prior: the calibration states no uncertainties."};
  const OpenVinsStates sigma = state_uncertainties(calibration, model);
  std::vector<std::string> out{
      "Prior: standard uncertainties of this calibration in OpenVINS' states. No key of its files takes them: state/State.cpp has constants",
      "(0.005 vec_dw, 0.008 vec_da, 0.005 vec_tg, 0.005 rad). nan: depends on a coefficient that was not estimated. The rotation's: about the axes",
      "of the IMU frame."};
  const auto line = [&](const char* name, int first, int count) {
    std::string text = fmt::format("  {}:", name);
    for (int k = first; k < first + count; ++k) text += fmt::format(" {:.2g}", sigma[k]);
    out.push_back(text);
  };
  line("vec_dw", 0, 6);
  line("vec_da", 6, 6);
  line("vec_tg", 12, 9);
  line(model == "rpng" ? "R_ACCtoIMU [rad]" : "R_GYROtoIMU [rad]", 21, 3);
  return out;
}

}  // namespace imulab::export_io
