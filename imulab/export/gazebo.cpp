// Gazebo (SDFormat <imu>; gazebosim/gz-sensors: src/GaussianNoiseModel.cc): a sample has white noise of stddev, and a bias b' = exp(-dt / t) b + w
// with the variance s^2 t / 2 (1 - exp(-2 dt / t)) of w, where s is dynamic_bias_stddev and t its correlation time. For dt far below t, that is s^2
// dt.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab::export_io {

namespace {

/// A walk in simulations of hours.
constexpr double walk_time_s = 1e5;

std::string triad_element(const char* element, const NoiseValue& N, const NoiseValue& K, double rate_hz) {
  if (N.missing) return {};  // the head says so
  const std::array<double, 3> white = each_axis(N), walk = each_axis(K);
  std::string out = fmt::format("  <{}>\n", element);
  for (std::size_t i = 0; i < 3; ++i)
    out += fmt::format(
        "    <{0}><noise type=\"gaussian\"><mean>0.0</mean><stddev>{1}</stddev><dynamic_bias_stddev>{2}</dynamic_bias_stddev>"
        "<dynamic_bias_correlation_time>{3}</dynamic_bias_correlation_time></noise></{0}>\n",
        "xyz"[i], exact_number(white[i] * std::sqrt(rate_hz)), exact_number(walk[i]), exact_number(walk_time_s));
  return out + fmt::format("  </{}>\n", element);
}

}  // namespace

std::string gazebo_text(const ExportInput& input) {
  const NoiseValues n = noise_values_by_axis(input, "Gazebo");
  const double rate_hz = n.rate_hz();
  const Sentences facts{
      fmt::format("Holds: stddev of a sample, N sqrt(rate): a DISCRETE value at {:g} Hz, which must be the sensor's update_rate.", rate_hz),
      fmt::format("dynamic_bias_stddev: the walk's density K, a CONTINUOUS value, with a correlation time of {:g} s.", walk_time_s),
      "Densities N: accelerometers " + n.accel_N.comment,
      "  gyros " + n.gyro_N.comment,
      "Densities K: accelerometers " + n.accel_K.comment,
      "  gyros " + n.gyro_K.comment,
      "Put <imu> into a <sensor type=\"imu\">. bias_mean is left out: it belongs to one unit."};
  std::string head = noise_head(input, "Gazebo (SDFormat)", facts, n, "");
  for (std::size_t at = 0; (at = head.find("--", at)) != std::string::npos;) head.replace(at, 2, "- -");  // which XML has not in a comment
  return "<!--\n" + head + "-->\n<imu>\n" + triad_element("angular_velocity", n.gyro_N, n.gyro_K, rate_hz) +
         triad_element("linear_acceleration", n.accel_N, n.accel_K, rate_hz) + "</imu>\n";
}

}  // namespace imulab::export_io
