// ORB-SLAM3 (UZ-SLAMLab/ORB_SLAM3 1.0: src/Settings.cc, src/Tracking.cc, src/ImuTypes.cc): densities; the code multiplies white noise by the root of
// IMU.Frequency, and divides the walks by it.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

std::string orb_slam3_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "ORB-SLAM3");
  const Sentences facts{
      "Holds: noise densities in CONTINUOUS time. ORB-SLAM3 makes those of a sample from them by IMU.Frequency, which must be the stream's.",
      "Put the lines into the settings file, beside IMU.T_b_c1. Correct the readings with `imulab compensate` before."};
  return "%YAML:1.0\n" + noise_head(input, "ORB-SLAM3", facts, n) + noise_line("IMU.NoiseGyro", n.gyro_N, "rad/s/sqrt(Hz)") +
         noise_line("IMU.NoiseAcc", n.accel_N, "m/s^2/sqrt(Hz)") + noise_line("IMU.GyroWalk", n.gyro_K, "rad/s^2/sqrt(Hz)") +
         noise_line("IMU.AccWalk", n.accel_K, "m/s^3/sqrt(Hz)") + fmt::format("IMU.Frequency: {}  # Hz\n", exact_number(n.rate_hz()));
}

}  // namespace imulab::export_io
