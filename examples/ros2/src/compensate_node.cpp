// A ROS 2 node that compensates an IMU: sensor_msgs/Imu in rad/s and m/s^2 on imu/data_raw becomes one on imu/data, with covariances of the noise at
// rest and of the calibration; temperatures come on imu/temperature, if the model needs them. Each second it states on /diagnostics how it goes.
//
// parameters: calibration, a file; rate_hz of the raw topic (0: that of the calibration's recordings)
#include <chrono>
#include <cstdio>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <exception>
#include <imulab/calibration.hpp>
#include <imulab/compensate.hpp>
#include <imulab/files.hpp>
#include <memory>
#include <optional>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/temperature.hpp>
#include <string>

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::Temperature;

class CompensateNode : public rclcpp::Node {
 public:
  CompensateNode()
      : Node("imulab_compensate"),
        file_(declare_parameter<std::string>("calibration", "calibration.json")),
        calibration_(imulab::read_calibration(file_)),
        compensator_(calibration_.model, {.leave_lever_arms = true}) {  // of readings in SI: a calibration of counts is refused
    set_noise(declare_parameter<double>("rate_hz", 0));
    publisher_ = create_publisher<Imu>("imu/data", rclcpp::QoS(10));
    diagnostics_ = create_publisher<DiagnosticArray>("/diagnostics", rclcpp::QoS(10));
    raw_ = create_subscription<Imu>("imu/data_raw", rclcpp::SensorDataQoS(), [this](const Imu::SharedPtr message) { compensate(*message); });
    if (compensator_.needs_temperature())
      temperature_topic_ = create_subscription<Temperature>("imu/temperature", rclcpp::SensorDataQoS(),
                                                            [this](const Temperature::SharedPtr message) { temperature_ = message->temperature; });
    timer_ = create_wall_timer(std::chrono::seconds(1), [this] { diagnose(); });
  }

 private:
  void set_noise(double rate_hz) {
    if (!calibration_.rest_noise) return;  // unknown: the covariances are those of the calibration alone
    const double interval = rate_hz > 0 ? 1 / rate_hz : calibration_.rest_noise->interval_s;
    rate_variance_ = calibration_.rest_noise->gyro.cwiseAbs2() / interval;
    force_variance_ = calibration_.rest_noise->accel.cwiseAbs2() / interval;
  }

  void compensate(const Imu& raw) {
    ++received_;
    const imulab::Vector3d gyro(raw.angular_velocity.x, raw.angular_velocity.y, raw.angular_velocity.z),
        accel(raw.linear_acceleration.x, raw.linear_acceleration.y, raw.linear_acceleration.z);
    const bool warm = compensator_.needs_temperature();
    if (!gyro.allFinite() || !accel.allFinite() || (warm && !temperature_)) {
      ++left_out_;
      return;
    }
    const imulab::Motion motion = warm ? compensator_(gyro, accel, *temperature_) : compensator_(gyro, accel);
    Imu out = raw;  // its stamp, frame and orientation
    out.angular_velocity.x = motion.rate[0], out.angular_velocity.y = motion.rate[1], out.angular_velocity.z = motion.rate[2];
    out.linear_acceleration.x = motion.force[0], out.linear_acceleration.y = motion.force[1], out.linear_acceleration.z = motion.force[2];
    // At the reference temperature: uncertain thermal terms are not in it.
    const auto covariance = imulab::output_covariance(calibration_, {.gyro = gyro, .accel = accel});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const auto at = static_cast<std::size_t>(3 * i + j);
        out.angular_velocity_covariance[at] = covariance(i, j) + (i == j ? rate_variance_[i] : 0);
        out.linear_acceleration_covariance[at] = covariance(3 + i, 3 + j) + (i == j ? force_variance_[i] : 0);
      }
    publisher_->publish(out);
  }

  void diagnose() {
    DiagnosticStatus status;
    status.name = "imulab: " + file_, status.hardware_id = calibration_.imu;
    status.level = received_ == 0 || left_out_ > 0 ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
    status.message = received_ == 0 ? "no message on imu/data_raw"
                     : left_out_ > 0
                         ? std::to_string(left_out_) + " of " + std::to_string(received_) + " messages left out: not finite, or no temperature yet"
                         : "compensates";
    DiagnosticArray message;
    message.header.stamp = now();
    message.status.push_back(status);
    diagnostics_->publish(message);
    received_ = left_out_ = 0;
  }

  std::string file_;
  imulab::Calibration calibration_;
  imulab::SampleCompensator compensator_;
  imulab::Vector3d rate_variance_ = imulab::Vector3d::Zero(), force_variance_ = imulab::Vector3d::Zero();
  std::optional<double> temperature_;  // degC
  std::size_t received_ = 0, left_out_ = 0;
  rclcpp::Publisher<Imu>::SharedPtr publisher_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Subscription<Imu>::SharedPtr raw_;
  rclcpp::Subscription<Temperature>::SharedPtr temperature_topic_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char** argv) try {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<CompensateNode>());
  rclcpp::shutdown();
} catch (const std::exception& e) {
  std::fprintf(stderr, "imulab_compensate: %s\n", e.what());
  return 1;
}
