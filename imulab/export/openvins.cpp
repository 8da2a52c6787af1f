// OpenVINS: kalibr_imu_chain.yaml (rpng/open_vins, commit 6948812: core/VioManagerOptions.h, state/State.h and State.cpp, state/Propagator.cpp).
#include "imulab/coefficient.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace imulab::export_io {

struct OpenVinsModel {
  Matrix3d Tw, R_IMUtoGYRO, Ta, R_IMUtoACC, Tg;
  Matrix3d C_I_b;  ///< from the calibration's body frame to the IMU frame
};
OpenVinsModel openvins_model(const ConsumerModel& m, const std::string& model);

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
  return c.frame == BodyFrame::accelerometers && k.triad == Triad::accel && k.term == Term::matrix && k.row < k.column &&
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

/// Lines with the standard uncertainties of its states vec_dw, vec_da (the triangles of T^-1, column by column), vec_tg (column by column) and of
/// the rotation it estimates, in the IMU frame: for the prior that state/State.cpp sets as constants (no key of its files does). NaN where a state
/// depends on coefficients that were not estimated. One line that says so where none was.
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

namespace {

constexpr Held openvins_holds{.g_sensitivity = true, .accel_matrix = true, .gyro_matrix = true, .accel_scale = true, .gyro_scale = true};

Sentences openvins_facts(const ConsumerModel& m, const OpenVinsModel& v, const NoiseValues& n, const std::string& model) {
  Sentences facts{"Holds: matrices, g-sensitivity, noise densities.",
                  "Readings from motion, I the IMU frame of OpenVINS:",
                  "  a_m = Ta R_IMUtoACC a_I + b_a          w_m = Tw R_IMUtoGYRO w_I + Tg a_I + b_g",
                  "so T are inverses of correction matrices, and biases are subtracted from readings. a_I: specific force, +g along up at rest.",
                  "Model \"" + model + "\": T are " + (model == "rpng" ? "upper" : "lower") + " triangular (exact factors of the whole matrices).",
                  "I = C b with b the body frame of the calibration and the rows of C " + row_text(v.C_I_b.row(0).transpose()) + ", " +
                      row_text(v.C_I_b.row(1).transpose()) + ", " + row_text(v.C_I_b.row(2).transpose()) + "; T_imu_cam of the cameras refers to I.",
                  "Tg is applied in the IMU frame: it equals Kalibr's A C_gyro_i, not A.",
                  "No key of this file holds the biases, OpenVINS estimates its own: b_a [m/s^2] " + row_text(m.accel.b) + ",",
                  "  b_g [rad/s] " + row_text(m.gyro.b)};
  facts.insert(facts.end(), n.facts.begin(), n.facts.end());
  return facts;
}

}  // namespace

OpenVinsModel openvins_model(const ConsumerModel& m, const std::string& model) {
  if (model != "kalibr" && model != "rpng") throw Error("OpenVINS has no IMU model \"" + plain(model) + "\"; expected kalibr or rpng");
  if (model == "rpng") {  // the IMU frame is the gyros'
    const TriangularFactors a = upper_factors(m.accel.T), g = upper_factors(m.gyro.T);
    return {g.triangle, Matrix3d::Identity(), a.triangle, a.Q * g.Q.transpose(), m.G * g.Q.transpose(), g.Q};
  }
  const TriangularFactors a = lower_factors(m.accel.T), g = lower_factors(m.gyro.T);
  return {g.triangle, g.Q * a.Q.transpose(), a.triangle, Matrix3d::Identity(), m.G * a.Q.transpose(), a.Q};
}

std::string openvins_text(const ExportInput& input) {
  const SensorModel& model = input.calibration.model;
  expect_si_readings(model);
  const ConsumerModel m = device_model(model, device_axes(input.calibration));
  expect_right_handed(m);
  const NoiseValues n = noise_values(input, "OpenVINS");
  const OpenVinsModel v = openvins_model(m, input.options.imu_model);
  Sentences facts = openvins_facts(m, v, n, input.options.imu_model);
  for (const Sentences& more : {input_facts(input.calibration), openvins_prior(input.calibration, input.options.imu_model)})
    facts.insert(facts.end(), more.begin(), more.end());
  std::string text =
      "%YAML:1.0\n" + comment_head(input, "OpenVINS (kalibr_imu_chain.yaml)", facts, left_out_of_openvins(input)) + "imu0:\n  T_i_b:\n";
  for (int i = 0; i < 4; ++i)
    text += fmt::format("    - [{}, {}, {}, {}]\n", i == 0 ? "1.0" : "0.0", i == 1 ? "1.0" : "0.0", i == 2 ? "1.0" : "0.0", i == 3 ? "1.0" : "0.0");
  text += noise_line("  accelerometer_noise_density", n.accel_N, "m/s^2/sqrt(Hz)") +
          noise_line("  accelerometer_random_walk", n.accel_K, "m/s^3/sqrt(Hz)") +
          noise_line("  gyroscope_noise_density", n.gyro_N, "rad/s/sqrt(Hz)") + noise_line("  gyroscope_random_walk", n.gyro_K, "rad/s^2/sqrt(Hz)");
  text += fmt::format("  rostopic: {}\n  time_offset: 0.0\n  update_rate: {}  # Hz\n  model: \"{}\"\n", topic_text(input), exact_number(n.rate_hz()),
                      input.options.imu_model);
  return text + matrix_text("  ", "Tw", v.Tw) + matrix_text("  ", "R_IMUtoGYRO", v.R_IMUtoGYRO) + matrix_text("  ", "Ta", v.Ta) +
         matrix_text("  ", "R_IMUtoACC", v.R_IMUtoACC) + matrix_text("  ", "Tg", v.Tg);
}

Sentences left_out_of_openvins(const ExportInput& input) {
  Sentences out = losses(input.calibration.model, openvins_holds);
  const Sentences noise = noise_left_out(input, "NK");
  out.insert(out.end(), noise.begin(), noise.end());
  return out;
}

}  // namespace imulab::export_io
