// ROS: the covariances of sensor_msgs/Imu as YAML (docs.ros.org: row-major about x, y, z; all zero: unknown; first element -1: no estimate).
#include "imulab/export/loss.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::export_io {

namespace {

/// Variance of a sample of white noise of density N: N^2 times the rate. An axis without noise has the largest of the others.
std::string ros_covariance(const char* key, const NoiseValue& N, double rate_hz, const char* unit) {
  double largest = 0;
  for (const double axis : N.axes)
    if (std::isfinite(axis)) largest = std::max(largest, axis);
  std::array<double, 3> variance{};
  for (std::size_t i = 0; i < 3; ++i) variance[i] = std::pow(std::isfinite(N.axes[i]) ? N.axes[i] : largest, 2) * rate_hz;
  return fmt::format("{}: [{}, 0.0, 0.0, 0.0, {}, 0.0, 0.0, 0.0, {}]  # {}; densities: {}\n", key, number_text(variance[0]), number_text(variance[1]),
                     number_text(variance[2]), unit, N.comment);
}

}  // namespace

std::string ros_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "sensor_msgs/Imu");
  Sentences facts{
      fmt::format("Variances of a sample, each axis its own: white noise N^2 times {:g} Hz. A stream that was low-passed has less.", n.rate_hz),
      "Holds: the covariance fields of the message, which filters such as robot_localization's weigh the measurement by: a driver copies them into",
      "each sensor_msgs/Imu. A filter whose noise is parameters of its own does not read them.",
      "Correct the readings with `imulab compensate` before. Orientation: -1, the message has none."};
  facts.push_back(n.facts.front());
  return comment_head(input, "ROS (sensor_msgs/Imu)", facts, left_out_of_ros(input)) +
         ros_covariance("linear_acceleration_covariance", n.accel_N, n.rate_hz, "(m/s^2)^2") +
         ros_covariance("angular_velocity_covariance", n.gyro_N, n.rate_hz, "(rad/s)^2") +
         "orientation_covariance: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n";
}

Sentences left_out_of_ros(const ExportInput& input) {
  Sentences out = whole_calibration_left_out(input);
  const Sentences noise = noise_left_out(input, false);
  out.insert(out.end(), noise.begin(), noise.end());
  return out;
}

}  // namespace imulab::export_io
