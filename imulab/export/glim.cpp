// GLIM (koide3/glim, commit 1007fec: src/glim/common/imu_integration.cpp, src/glim/odometry/odometry_estimation_imu.cpp): densities, whose squares
// are GTSAM's covariances; imu_bias_noise is the standard deviation of the change of all six biases from one scan to the next, m/s^2 and rad/s alike.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::export_io {

namespace {

constexpr double scans_hz = 10;  // of most lidars

/// The change of biases between two scans: the larger of both triads, so that no bias is trusted too long.
double bias_step(const NoiseValues& n) { return std::max(n.accel_K.value, n.gyro_K.value) / std::sqrt(scans_hz); }

std::string glim_line(const char* key, double value, const std::string& comment) {
  return fmt::format("    \"{}\": {},  // {}\n", key, exact_number(value), comment);
}

}  // namespace

std::string glim_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "GLIM");
  const Sentences facts{
      "Holds: imu_acc_noise and imu_gyro_noise, noise densities in CONTINUOUS time.",
      fmt::format("imu_bias_noise: a DISCRETE value, K / sqrt(rate) of {:g} scans/s. At another scan rate multiply it by sqrt({:g} / rate).",
                  scans_hz, scans_hz),
      "One number stands for the biases of accelerometers [m/s^2] and gyros [rad/s]: the larger.",
      "Put the lines into \"sensors\" of config_sensors.json. imu_int_noise is GTSAM's error of integration, not the IMU's: keep GLIM's.",
      "Correct the readings with `imulab compensate` before."};
  return noise_head(input, "GLIM", facts, n, "//") + "{\n  \"sensors\": {\n" +
         triad_text(n.accel_N, glim_line("imu_acc_noise", n.accel_N.value, "m/s^2/sqrt(Hz); " + n.accel_N.comment), "    //") +
         triad_text(n.gyro_N, glim_line("imu_gyro_noise", n.gyro_N.value, "rad/s/sqrt(Hz); " + n.gyro_N.comment), "    //") +
         fmt::format("    // densities K: accelerometers [m/s^3/sqrt(Hz)] {}\n    //   gyros [rad/s^2/sqrt(Hz)] {}\n", n.accel_K.comment,
                     n.gyro_K.comment) +
         fmt::format("    \"imu_bias_noise\": {}\n  }}\n}}\n", exact_number(bias_step(n)));
}

Sentences warnings_of_glim(const ExportInput& input) {
  Sentences out = warnings_of_walk(input);
  const NoiseValues n = noise_values(input, "GLIM");
  if (n.accel_K.missing || n.gyro_K.missing) return out;
  const bool of_accel = n.accel_K.value > n.gyro_K.value;
  const double ratio = of_accel ? n.accel_K.value / n.gyro_K.value : n.gyro_K.value / n.accel_K.value;
  out.push_back(
      fmt::format("imu_bias_noise is one number for all biases, that of the {}: GLIM lets the biases of the {} change {:.2g} times as fast as "
                  "they do",
                  of_accel ? "accelerometers" : "gyros", of_accel ? "gyros" : "accelerometers", ratio));
  return out;
}

}  // namespace imulab::export_io
