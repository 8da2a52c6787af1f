#include "imulab/navigation/integration/attitude.hpp"

#include <cmath>

namespace imulab {

Eigen::Matrix3d attitude_matrix(const EulerAngles& angles) {
  const double sr = std::sin(angles.roll), cr = std::cos(angles.roll), sp = std::sin(angles.pitch), cp = std::cos(angles.pitch);
  const double sh = std::sin(angles.heading), ch = std::cos(angles.heading);
  Eigen::Matrix3d c;                                              // Rz(-heading) Rx(pitch) Ry(roll)
  c << ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr,   //
      -sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr,  //
      -cp * sr, sp, cp * cr;
  return c;
}

EulerAngles euler_angles(const Eigen::Matrix3d& c) {
  const double level = std::hypot(c(2, 0), c(2, 2));
  const double pitch = std::atan2(c(2, 1), level);
  if (level < 1e-12) return {0, pitch, std::atan2(-c(1, 0), c(0, 0))};
  return {std::atan2(-c(2, 0), c(2, 2)), pitch, std::atan2(c(0, 1), c(1, 1))};
}

Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative) {
  const double sr = std::sin(angles.roll), cr = std::cos(angles.roll), sp = std::sin(angles.pitch), cp = std::cos(angles.pitch);
  const double vertical = -derivative.heading * cp;  // the heading's part along the body's up axis before the roll
  return {derivative.pitch * cr - vertical * sr, derivative.roll - derivative.heading * sp, derivative.pitch * sr + vertical * cr};
}

}  // namespace imulab
