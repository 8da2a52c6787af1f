#include "imulab/formats/solution/odometry.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>

namespace imulab {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

constexpr std::string_view odometry_definition = R"(std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
)";

/// Columns: forward, left, up in axes right, forward, up.
Matrix3d forward_left_up() { return (Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished(); }

/// East, north, up in Earth-fixed axes.
Matrix3d east_north_up(const NavigationState& s) {
  const double sL = std::sin(s.latitude), cL = std::cos(s.latitude), sl = std::sin(s.longitude), cl = std::cos(s.longitude);
  return (Matrix3d() << -sl, -sL * cl, cL * cl, cl, -sL * sl, cL * sl, 0, cL, sL).finished();
}

Vector3d earth_fixed(const NavigationState& s) {
  constexpr double e2 = 6.69437999014e-3;  // WGS-84
  const double RN = local_earth(s.latitude, s.height).transverse_radius - s.height, across = (RN + s.height) * std::cos(s.latitude);
  return {across * std::cos(s.longitude), across * std::sin(s.longitude), ((1 - e2) * RN + s.height) * std::sin(s.latitude)};
}

struct Odometry {
  Vector3d position, velocity, rate;  // map [m]; base_link [m/s], [rad/s]
  Eigen::Quaterniond attitude;        // base_link to map
  Matrix6d pose_covariance, twist_covariance = Matrix6d::Zero();
};

/// In a map with these axes and this origin, Earth-fixed; `rate`: right, forward, up.
Odometry odometry_of(const NavigationState& s, const Matrix9d& P, const Vector3d& rate, const Matrix3d& map, const Vector3d& origin) {
  const Matrix3d R = map.transpose() * east_north_up(s), B = s.q_nb.toRotationMatrix() * forward_left_up();
  Odometry out;
  out.position = map.transpose() * (earth_fixed(s) - origin);
  out.attitude = Eigen::Quaterniond(R * B);
  out.velocity = B.transpose() * s.velocity;
  out.rate = forward_left_up().transpose() * rate;
  Eigen::Matrix<double, 6, 9> pose = Eigen::Matrix<double, 6, 9>::Zero();
  pose.block<3, 3>(0, 6) = R, pose.block<3, 3>(3, 0) = R;
  out.pose_covariance = pose * P * pose.transpose();
  // B^T v, with C = (I + [phi x]) C_hat: d = B^T (dv + v x phi)
  Eigen::Matrix<double, 3, 9> twist = Eigen::Matrix<double, 3, 9>::Zero();
  twist.block<3, 3>(0, 0) = B.transpose() * skew(s.velocity), twist.block<3, 3>(0, 3) = B.transpose();
  out.twist_covariance.topLeftCorner<3, 3>() = twist * P * twist.transpose();
  return out;
}

/// The mean over a step, in body axes.
Vector3d mean_rate(double from, const NavigationState& before, double to, const NavigationState& after) {
  const Eigen::AngleAxisd turn(before.q_nb.conjugate() * after.q_nb);
  const double angle = std::remainder(turn.angle(), 2 * std::numbers::pi), step = to - from;
  return step > 0 ? Vector3d(turn.axis() * (angle / step)) : Vector3d::Zero();
}

/// Numbers are aligned to their size after the encapsulation.
std::string odometry_message(std::int64_t stamp, const Odometry& o) {
  constexpr std::size_t head = 4;
  std::string out("\0\1\0\0", head);
  const auto align = [&](std::size_t size) { out.append((size - (out.size() - head) % size) % size, '\0'); };
  const auto text = [&](std::string_view s) {
    align(4);
    bag::append<std::uint32_t>(out, static_cast<std::uint32_t>(s.size() + 1));
    (out += s) += '\0';
  };
  const auto numbers = [&](const auto& values) {
    align(8);
    for (Eigen::Index k = 0; k < values.size(); ++k) bag::append<double>(out, values.data()[k]);
  };
  constexpr std::int64_t second = 1'000'000'000;
  const std::int64_t below = (stamp % second + second) % second;
  bag::append<std::int32_t>(out, static_cast<std::int32_t>((stamp - below) / second));
  bag::append<std::uint32_t>(out, static_cast<std::uint32_t>(below));
  text("map"), text("base_link");
  numbers(o.position), numbers(o.attitude.coeffs()), numbers(o.pose_covariance);
  numbers(o.velocity), numbers(o.rate), numbers(o.twist_covariance);
  return out;
}

}  // namespace

OdometryFile::OdometryFile(const std::filesystem::path& path) : file_(path, {"/imulab/odometry", "nav_msgs/msg/Odometry", odometry_definition}) {}

void OdometryFile::add(const AidedNavigation& n, double time, const NavigationState& state) {
  const Reached now{time, state, covariance_at(n, time)};
  if (!before_) {
    map_ = east_north_up(state), origin_ = earth_fixed(state);
    first_ = before_ = now;
    return;
  }
  const Vector3d rate = mean_rate(before_->time, before_->state, time, state);
  if (first_) write(*first_, rate), first_.reset();
  write(now, rate);
  before_ = now;
}

void OdometryFile::write(const Reached& r, const Vector3d& rate) {
  const auto stamp = static_cast<std::int64_t>(std::llround(r.time * 1e9));
  file_.add(stamp, odometry_message(stamp, odometry_of(r.state, r.covariance, rate, map_, origin_)));
}

void OdometryFile::commit() {
  if (first_) write(*first_, Vector3d::Zero());
  file_.commit();
}

}  // namespace imulab
