// Strapdown integration on the WGS-84 ellipsoid in east-north-up axes: from increments to attitude, velocity and position.
#pragma once

#include "imulab/earth/earth.hpp"
#include "imulab/navigation/integration/attitude.hpp"
#include "imulab/navigation/integration/increment.hpp"

#include <Eigen/Geometry>

#include <optional>
#include <string_view>

namespace imulab {

struct NavigationState {
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  // body to east-north-up
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        // against the Earth, east-north-up [m/s]
  double latitude = 0, longitude = 0;                        // geodetic [rad]
  double height = 0;                                         // above the ellipsoid [m]
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

}  // namespace imulab
