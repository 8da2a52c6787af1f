// ROS: the covariances of sensor_msgs/Imu as YAML (docs.ros.org: row-major about x, y, z; all zero: unknown; first element -1: no estimate).
#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::export_io {

namespace {

/// Variance of a sample of white noise of density N: N^2 times the rate.
std::string ros_covariance(const char* key, const NoiseValue& N, double rate_hz, const char* unit) {
  std::array<double, 3> variance = each_axis(N);
  for (double& axis : variance) axis *= axis * rate_hz;
  return triad_text(N,
                    fmt::format("{}: [{}, 0.0, 0.0, 0.0, {}, 0.0, 0.0, 0.0, {}]  # {}; densities: {}\n", key, exact_number(variance[0]),
                                exact_number(variance[1]), exact_number(variance[2]), unit, N.comment),
                    fmt::format("# {}", key));
}

}  // namespace

std::string ros_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "sensor_msgs/Imu");
  Sentences facts{
      fmt::format("Variances of a sample, each axis its own: white noise N^2 times {:g} Hz. A stream that was low-passed has less.", n.rate_hz()),
      "Holds: the covariance fields of the message, which filters such as robot_localization's weigh the measurement by: a driver copies them into",
      "each sensor_msgs/Imu. A filter whose noise is parameters of its own does not read them.",
      "Correct the readings with `imulab compensate` before. Orientation: -1, the message has none."};
  facts.push_back(n.facts.front());
  return comment_head(input, "ROS (sensor_msgs/Imu)", facts, left_out_of_ros(input)) +
         ros_covariance("linear_acceleration_covariance", n.accel_N, n.rate_hz(), "(m/s^2)^2") +
         ros_covariance("angular_velocity_covariance", n.gyro_N, n.rate_hz(), "(rad/s)^2") +
         "orientation_covariance: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n";
}

// Parameters of imu_tools' orientation filters as a ROS 2 parameter file (CCNYRoboticsLab/imu_tools: imu_filter_madgwick/src/imu_filter_ros.cpp,
// imu_complementary_filter/src/complementary_filter.cpp and complementary_filter_ros.cpp).

namespace {

constexpr double largest_gain = 1;     // of imu_filter_madgwick: what its parameter's range admits
constexpr double still_change = 0.01;  // rad/s: changes from sample to sample beyond it are motion to imu_complementary_filter
constexpr double seldom_beyond = 3;    // standard deviations
constexpr double offset_sigmas = 3;    // that the gain has to hold an offset of
constexpr std::size_t gyro_offset_axes = 3;

/// The rate error of the gyros that the filter has to hold: of the worst axis, in the output. NaN: not known.
struct RateError {
  double white = 0, wander = 0, offset = 0;
  double sum() const { return white + wander + (std::isfinite(offset) ? offset_sigmas * offset : 0); }
};

RateError rate_error(const ExportInput& input, const NoiseValues& n) {
  RateError e;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::isfinite(n.gyro_N.axes[i])) e.white = std::max(e.white, n.gyro_N.axes[i] * std::sqrt(n.rate_hz()));
    if (input.noise == nullptr || !input.noise->gyro[i]) continue;
    const NoiseCoefficient& B = input.noise->gyro[i]->B;
    const double size = B.determined ? B.value : B.upper;
    if (std::isfinite(size)) e.wander = std::max(e.wander, size);
  }
  for (std::size_t i = 0; i < gyro_offset_axes; ++i) {
    const auto sigma = standard_uncertainty(input.calibration, coefficient_index(fmt::format("gyro.offset.{}", "xyz"[i])));
    e.offset = sigma && std::isfinite(*sigma) ? std::max(e.offset, *sigma) : std::nan("");
  }
  return e;
}

}  // namespace

std::string ros_filter_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "imu_filter");
  if (n.gyro_N.missing) throw Error("imu_filter: needs the gyros' noise, and the noise has none; expected a log of the gyros");
  const RateError error = rate_error(input, n);
  const double gain = std::sqrt(0.75) * error.sum(), change = std::sqrt(2.0) * error.white;
  if (!(gain <= largest_gain))
    throw Error(fmt::format("imu_filter: its gain would be {:.3g}, of gyros uncertain by {:.3g} rad/s; it takes at most {:g}", gain, error.sum(),
                            largest_gain));
  const bool still_seen = seldom_beyond * change < still_change;
  Sentences facts{
      "Holds: parameters that follow from the noise and from the calibration's uncertainty; all others keep the filters' defaults.",
      "For the nodes of imu_filter_madgwick and imu_complementary_filter: --ros-args --params-file FILE. ROS 1: the lines below ros__parameters "
      "alone.",
      fmt::format("gain = sqrt(3/4) times the gyros' rate error of the worst axis (Madgwick's report of 2010, filter gains): white noise of a sample "
                  "{:.3g}, B {}, {}",
                  error.white, input.noise != nullptr ? fmt::format("{:.3g}", error.wander) : "NOT MEASURED and left out",
                  std::isfinite(error.offset) ? fmt::format("3 times the offset's uncertainty {:.3g} rad/s.", error.offset)
                                              : std::string("rad/s; the offset's uncertainty is not known.")),
      "Offsets that change from one turn-on to the next, with temperature or with motion are not in it: where there are any, it must hold these too.",
      fmt::format(
          "imu_complementary_filter takes the IMU as still where no sample differs by more than 0.01 rad/s from the last: white noise {:.3g}, {}",
          change, still_seen ? "so that it sees rests." : "so that it seldom sees a rest: it would learn no offsets."),
      "Correct the readings with `imulab compensate` before. There is no magnetometer in this calibration."};
  facts.push_back(n.facts.front());
  return comment_head(input, "ROS 2 (imu_tools)", facts, left_out_of_ros(input)) +
         fmt::format(
             "/**:\n  ros__parameters:\n    use_mag: false\n    constant_dt: 0.0  # the messages' stamps\n"
             "    gain: {}  # imu_filter_madgwick\n    zeta: 0.0  # imu_filter_madgwick: without a magnetometer it learns no offsets\n"
             "    do_bias_estimation: {}  # imu_complementary_filter\n",
             exact_number(gain), still_seen);
}

}  // namespace imulab::export_io
