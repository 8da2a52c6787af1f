#pragma once

#include <array>
#include <cstdio>
#include <memory>

namespace sensor_msgs::msg {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};
struct Imu {
  using SharedPtr = std::shared_ptr<Imu>;
  double stamp = 0;
  Vector3 angular_velocity, linear_acceleration;
  std::array<double, 9> angular_velocity_covariance{}, linear_acceleration_covariance{};
};
inline bool fill(Imu& imu, const double* row) {
  imu.stamp = row[0], imu.angular_velocity = {row[1], row[2], row[3]}, imu.linear_acceleration = {row[4], row[5], row[6]};
  return true;
}
inline void print(const Imu& imu) {
  const Vector3 &w = imu.angular_velocity, &f = imu.linear_acceleration;
  std::printf("%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.3g %.3g\n", imu.stamp, w.x, w.y, w.z, f.x, f.y, f.z, imu.angular_velocity_covariance[0],
              imu.linear_acceleration_covariance[8]);
}

}  // namespace sensor_msgs::msg
