// Kalibr: imu.yaml, its input, and the file with IMU intrinsics that it writes (ethz-asl/kalibr, commit 1f60227: kalibr_common/ConfigReader.py and
// kalibr_imu_camera_calibration/IccSensors.py, class IccScaledMisalignedImu).
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

constexpr Held kalibr_holds{.g_sensitivity = true, .accel_matrix = true, .gyro_matrix = true, .accel_scale = true, .gyro_scale = true};

/// Keys of the noise, which all of Kalibr's files and those after its pattern share.
std::string noise_keys(const std::string& indent, const NoiseValues& n, const std::string& topic) {
  return fmt::format("{}rostopic: {}\n{}update_rate: {}  # Hz\n", indent, topic, indent, exact_number(n.rate_hz())) +
         noise_line(indent + "accelerometer_noise_density", n.accel_N, "m/s^2/sqrt(Hz)") +
         noise_line(indent + "accelerometer_random_walk", n.accel_K, "m/s^3/sqrt(Hz)") +
         noise_line(indent + "gyroscope_noise_density", n.gyro_N, "rad/s/sqrt(Hz)") +
         noise_line(indent + "gyroscope_random_walk", n.gyro_K, "rad/s^2/sqrt(Hz)");
}

}  // namespace

std::string kalibr_imu_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "Kalibr");
  return noise_head(input, "Kalibr (input)",
                    {"Holds: continuous-time noise densities, Kalibr's imu.yaml. Correct the readings with `imulab compensate` before."}, n) +
         noise_keys("", n, topic_text(input));
}

std::string kalibr_text(const ExportInput& input) {
  const SensorModel& model = input.calibration.model;
  expect_si_readings(model);
  const ConsumerModel m = device_model(model, device_axes(input.calibration));
  expect_right_handed(m);
  const NoiseValues n = noise_values(input, "Kalibr");
  // a_m = M_a (C_i_b a_b) + b_a,  w_m = M_g (C_gyro_i C_i_b w_b) + A (C_gyro_i C_i_b a_b) + b_g, with M_a and M_g lower triangular.
  const TriangularFactors a = lower_factors(m.accel.T), g = lower_factors(m.gyro.T);
  const Matrix3d C_gyro_i = g.Q * a.Q.transpose(), A = m.G * g.Q.transpose();
  Sentences facts{"Holds: matrices, g-sensitivity, noise densities.",
                  "Readings from motion, b the body frame of the calibration, i the IMU frame:",
                  "  a_m = M_a C_i_b a_b + b_a          w_m = M_g C_gyro_i C_i_b w_b + A C_gyro_i C_i_b a_b + b_g",
                  "so M is the inverse of a correction matrix, and biases are subtracted from readings. a_b: specific force, +g along up at rest.",
                  "M are lower triangular (exact factors of the whole matrices); C_i_b is the rotation of T_i_b.",
                  "No key of this file holds the biases, Kalibr estimates its own: b_a [m/s^2] " + row_text(m.accel.b) + ",",
                  "  b_g [rad/s] " + row_text(m.gyro.b)};
  for (const Sentences& more : {input_facts(input.calibration), n.facts}) facts.insert(facts.end(), more.begin(), more.end());
  std::string text = comment_head(input, "Kalibr (result form)", facts, left_out_of_kalibr(input));
  text += "imu0:\n  T_i_b:\n";
  for (int i = 0; i < 3; ++i)
    text += fmt::format("    - [{}, {}, {}, 0.0]\n", exact_number(a.Q(i, 0)), exact_number(a.Q(i, 1)), exact_number(a.Q(i, 2)));
  text += "    - [0.0, 0.0, 0.0, 1.0]\n  time_offset: 0.0\n" + noise_keys("  ", n, topic_text(input)) +
          "  model: scale-misalignment\n  accelerometers:\n" + matrix_text("    ", "M", a.triangle) + "  gyroscopes:\n" +
          matrix_text("    ", "M", g.triangle) + matrix_text("    ", "A", A) + matrix_text("    ", "C_gyro_i", C_gyro_i);
  return text;
}

Sentences left_out_of_kalibr(const ExportInput& input) {
  Sentences out = losses(input.calibration.model, kalibr_holds);
  const Sentences noise = noise_left_out(input, "NK");
  out.insert(out.end(), noise.begin(), noise.end());
  return out;
}

}  // namespace imulab::export_io
