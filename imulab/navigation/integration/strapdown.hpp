// Strapdown integration on the WGS-84 ellipsoid in east-north-up axes: from increments to attitude, velocity and position (docs/navigation.md).
//
//   C_nb' = C_nb [w_ib_b x] - [w_in_n x] C_nb,   v' = C_nb f_b + g(L, h) - (2 w_ie + w_en) x v,   L' = vN / (RM + h), ...
//
//   Strapdown navigator(start, {.vertical = VerticalChannel::fixed});
//   for (const Increment& sample : increments) navigator.step(sample, 0.01);
//   navigator.state().latitude                                    // rad
//
// Valid for latitudes within 89.9 deg. Savage 1998, doi:10.2514/2.4228 and 10.2514/2.4242.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/navigation/integration/increment.hpp"

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

// Attitude angles: roll, pitch, heading of the body axes (right, forward, up) against east, north, up.

struct EulerAngles {
  double roll = 0;     // right side down [rad]
  double pitch = 0;    // up [rad]
  double heading = 0;  // clockwise from north [rad]
};

/// Body to east-north-up.
Eigen::Matrix3d attitude_matrix(const EulerAngles& angles);

/// The angles of an attitude: roll and heading in (-pi, pi], pitch in [-pi/2, pi/2]. At a pitch of 90 deg roll is zero.
EulerAngles euler_angles(const Eigen::Matrix3d& C_nb);

/// Rate of the body against east-north-up, in body axes (w_nb_b), from the angles and their time derivatives.
Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative);

struct NavigationState {
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  // body to east-north-up
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        // against the Earth, east-north-up [m/s]
  double latitude = 0, longitude = 0;                        // geodetic [rad]
  double height = 0;                                         // above the ellipsoid [m]
};

/// A barometer's heights over time [s, m].
struct HeightRecord {
  std::vector<double> time, height;
};

/// Treatment of the height, whose pure inertial error grows by a factor e every 570 s: state the vertical channel with every result.
enum class VerticalChannel {
  free,   ///< integrated like the others
  fixed,  ///< height as at the start, no vertical velocity
  aided,  ///< corrected towards a barometer's height by a loop of third order
  held,   ///< the height is the barometer's, the vertical velocity is integrated freely
};
std::string_view to_string(VerticalChannel vertical);

struct StrapdownOptions {
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<double> gravity = {};    // constant, straight down [m/s^2]; absent: WGS-84 normal gravity at each place
  double barometer_time_constant = 100;  // of the loop's three poles [s]
  double latitude_limit = 1.5690509975;  // 89.9 deg; Error beyond: close to a pole the axes turn too fast [rad]
  bool previous_sample = true;           // coning and sculling of a single sample with the one before
};

namespace integration {
/// The Earth at a place, with the options' gravity where they have one.
LocalEarth earth_at(double latitude, double height, const StrapdownOptions& options);
/// Throws Error beyond the limit (either way from the equator) [rad].
void expect_latitude(double latitude, double limit = StrapdownOptions{}.latitude_limit);
}  // namespace integration

/// The integration: a state, and the values that one step passes on to the next.
class Strapdown {
 public:
  /// Throws Error for a start that is not finite, whose quaternion is not of length one or whose latitude is beyond the limit, and for options out of
  /// range.
  explicit Strapdown(const NavigationState& start, const StrapdownOptions& options = {});

  /// One sample over `interval` [s]. `barometer` [m]: the height at the end of the step, for the aided and the held channel. Throws Error where the
  /// latitude leaves the limit.
  void step(const Increment& sample, double interval, std::optional<double> barometer = {});
  /// One to five samples over `interval` [s] altogether.
  void step(std::span<const Increment> samples, double interval, std::optional<double> barometer = {});

  const NavigationState& state() const { return state_; }

 private:
  void advance(const integration::BodyStep& body, double interval);
  void aid(double barometer, double interval);

  NavigationState state_;
  StrapdownOptions options_;
  LocalEarth earth_;                   // at the last step's middle
  Eigen::Vector3d slow_;               // gravity and Coriolis acceleration there [m/s^2]
  std::optional<Increment> previous_;  // the last single sample
  bool lacking_ = false;               // it was the first, integrated without one before it
  double barometer_integral_ = 0;      // of height minus barometer, times its gain [m/s^2]
};

// Attitude, velocity and position over time: the result of navigation, and the reference it is compared with.

struct Solution {
  std::vector<double> time;  // s, ascending
  std::vector<NavigationState> states;
  std::size_t size() const { return time.size(); }
};

}  // namespace imulab
