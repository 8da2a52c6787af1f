// EuRoC / ASL: sensor.yaml of an IMU folder (keys as in the files of the EuRoC MAV dataset, mav0/imu0/sensor.yaml).
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

std::string euroc_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "the EuRoC form");
  return noise_head(
             input, "the EuRoC / ASL form (sensor.yaml)",
             {"Holds: continuous-time noise densities and the rate. T_BS: the sensor is the body. Correct the readings with `imulab compensate` "
              "before."},
             n) +
         "sensor_type: imu\ncomment: IMU\nT_BS:\n  cols: 4\n  rows: 4\n"
         "  data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n" +
         fmt::format("rate_hz: {}\n", exact_number(n.rate_hz())) + noise_line("gyroscope_noise_density", n.gyro_N, "rad/s/sqrt(Hz)") +
         noise_line("gyroscope_random_walk", n.gyro_K, "rad/s^2/sqrt(Hz)") + noise_line("accelerometer_noise_density", n.accel_N, "m/s^2/sqrt(Hz)") +
         noise_line("accelerometer_random_walk", n.accel_K, "m/s^3/sqrt(Hz)");
}

}  // namespace imulab::export_io
