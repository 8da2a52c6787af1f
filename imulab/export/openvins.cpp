// OpenVINS: kalibr_imu_chain.yaml (rpng/open_vins, commit 6948812: core/VioManagerOptions.h, state/State.h and State.cpp, state/Propagator.cpp).
#include "imulab/core/error.hpp"
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/openvins_prior.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

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
  text += fmt::format("  rostopic: /imu0\n  time_offset: 0.0\n  update_rate: {}  # Hz\n  model: \"{}\"\n", number_text(n.rate_hz),
                      input.options.imu_model);
  return text + matrix_text("  ", "Tw", v.Tw) + matrix_text("  ", "R_IMUtoGYRO", v.R_IMUtoGYRO) + matrix_text("  ", "Ta", v.Ta) +
         matrix_text("  ", "R_IMUtoACC", v.R_IMUtoACC) + matrix_text("  ", "Tg", v.Tg);
}

Sentences left_out_of_openvins(const ExportInput& input) {
  Sentences out = losses(input.calibration.model, openvins_holds);
  const Sentences noise = noise_left_out(input, true);
  out.insert(out.end(), noise.begin(), noise.end());
  return out;
}

}  // namespace imulab::export_io
