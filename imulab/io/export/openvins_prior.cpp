#include "imulab/io/export/openvins_prior.hpp"

#include "imulab/model/coefficient.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <cmath>

namespace imulab::export_io {

namespace {

constexpr int state_count = 24;  // vec_dw 6, vec_da 6, vec_tg 9, rotation 3
using OpenVinsStates = Eigen::Matrix<double, state_count, 1>;

void put_triangle(const Matrix3d& D, bool upper, int first, OpenVinsStates& out) {
  int k = first;
  for (int j = 0; j < 3; ++j)
    for (int i = upper ? 0 : j; upper ? i <= j : i < 3; ++i) out[k++] = D(i, j);
}

/// The states of a model; the rotation as the rotation vector against that of `start`.
OpenVinsStates openvins_states(const SensorModel& model, const std::string& which, const Matrix3d& start) {
  const OpenVinsModel v = openvins_model(consumer_model(model), which);
  OpenVinsStates out;
  put_triangle(v.Tw.inverse(), which == "rpng", 0, out);
  put_triangle(v.Ta.inverse(), which == "rpng", 6, out);
  for (int k = 0; k < 9; ++k) out[12 + k] = v.Tg(k % 3, k / 3);
  out.tail<3>() = rotation_log((which == "rpng" ? v.R_IMUtoACC : v.R_IMUtoGYRO) * start.transpose());
  return out;
}

}  // namespace

std::vector<std::string> openvins_prior(const Calibration& calibration, const std::string& model) {
  const auto size = static_cast<Eigen::Index>(calibration.estimated.size());
  if (size == 0) return {"Prior: the calibration states no uncertainties."};
  const OpenVinsModel v = openvins_model(consumer_model(calibration.model), model);
  const Matrix3d start = model == "rpng" ? v.R_IMUtoACC : v.R_IMUtoGYRO;
  // The derivative of the states by each coefficient: central differences, with a step that rounding and curvature allow for coefficients near one.
  Eigen::MatrixXd jacobian(state_count, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const CoefficientIndex index = calibration.estimated[static_cast<std::size_t>(i)];
    constexpr double step = 1e-6;
    SensorModel more = calibration.model, less = calibration.model;
    set_coefficient(more, index, coefficient_value(more, index) + step);
    set_coefficient(less, index, coefficient_value(less, index) - step);
    jacobian.col(i) = (openvins_states(more, model, start) - openvins_states(less, model, start)) / (2 * step);
  }
  const Eigen::VectorXd sigma = (jacobian * calibration.covariance * jacobian.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  std::vector<std::string> out{
      "Prior: standard uncertainties of this calibration in OpenVINS' states. No key of its files takes them: state/State.cpp has constants",
      "(0.005 vec_dw, 0.008 vec_da, 0.005 vec_tg, 0.005 rad). 0: not estimated, or zero by the choice of the frame."};
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
