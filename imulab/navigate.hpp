// Inertial navigation: alignment at rest and strapdown integration on the WGS-84 ellipsoid in east-north-up axes, of samples as they come or of a
// recording with its calibration (docs/theory/strapdown.md).
//
//   C_nb' = C_nb [w_ib_b x] - [w_in_n x] C_nb,   v' = C_nb f_b + g(L, h) - (2 w_ie + w_en) x v,   L' = vN / (RM + h), ...
//
// Example:
//   Strapdown navigator(NavigationState{.latitude = 45 * unit::deg}, {.vertical = VerticalChannel::fixed});
//   navigator.step(Increment{.angle = {0, 0, 1e-4}, .velocity = {0, 0, 0.0981}}, 0.01);
//   std::printf("%g\n", navigator.state().latitude);  // rad
//   const Navigated drive = navigate(calibration, session, recording, {.vertical = VerticalChannel::fixed});
//
// Body axes are right, forward, up. Valid for latitudes within 89.9 deg; rests to align on of 10 s and more. A constant gyro error e east leaves e /
// (w_ie cos L) of heading, a constant accelerometer error b leaves b / g of tilt: the covariance of an alignment includes both. Savage 1998,
// doi:10.2514/2.4228 and 10.2514/2.4242. Throws Error for a start or readings that no motion has, Unsupported where a rest does not show the heading.
// A Strapdown is used by one thread at a time.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Integrals over an interval in body axes: of the angular rate [rad] and of the specific force [m/s].
struct Increment {
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// An increment and the length [s] of its interval.
struct TimedIncrement {
  Increment increment;
  double interval = 0;
};

namespace integration {
struct BodyStep;
}

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

struct StrapdownOptions {
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<double> gravity = {};    // constant, straight down [m/s^2]; absent: WGS-84 normal gravity at each place
  double barometer_time_constant = 100;  // of the loop's three poles [s]
  double latitude_limit = 1.5690509975;  // 89.9 deg; Error beyond: close to a pole the axes turn too fast [rad]
  bool previous_sample = true;           // coning and sculling of a single sample with the one before
};

/// The integration: a state, and the values that one step passes on to the next.
class Strapdown {
 public:
  /// Throws Error for a start that is not finite, whose quaternion is not of length one or whose latitude is beyond the limit, and for options out of
  /// range.
  explicit Strapdown(const NavigationState& start, const StrapdownOptions& options = {});

  /// One sample over `interval` [s]. `barometer` [m]: the height at the end of the step, for the aided and the held channel. Throws Error for an
  /// interval that is not positive, and where the latitude leaves the limit.
  void step(const Increment& sample, double interval, std::optional<double> barometer = {});
  /// One to five samples over `interval` [s] altogether.
  void step(std::span<const Increment> samples, double interval, std::optional<double> barometer = {});

  const NavigationState& state() const { return state_; }

 private:
  void advance(const integration::BodyStep& body, double interval);
  void aid(double barometer, double interval);

  NavigationState state_;
  StrapdownOptions options_;
  LocalEarth earth_;                        // at the last step's middle
  Eigen::Vector3d slow_;                    // gravity and Coriolis acceleration there [m/s^2]
  std::optional<Increment> previous_ = {};  // the last single sample
  bool lacking_ = false;                    // it was the first, integrated without one before it
  double barometer_integral_ = 0;           // of height minus barometer, times its gain [m/s^2]
};

// Attitude, velocity and position over time: the result of navigation, and the reference it is compared with.

struct Solution {
  std::vector<double> time = {};  // s, ascending
  std::vector<NavigationState> states = {};
  std::size_t size() const { return time.size(); }
};

struct AlignmentSite {
  double latitude = 0;  // rad, at most 89.9 deg either way
  double gravity = 0;   // m/s^2
};

/// Errors of the sensors: constant ones by their covariance in body axes, white noise by its density.
struct AlignmentSensors {
  Eigen::Matrix3d gyro_bias = Eigen::Matrix3d::Zero();   // (rad/s)^2
  Eigen::Matrix3d accel_bias = Eigen::Matrix3d::Zero();  // (m/s^2)^2
  std::optional<double> gyro_noise = {};                 // rad/s/sqrt(Hz); absent: estimated from the rest
  std::optional<double> accel_noise = {};                // m/s^2/sqrt(Hz); likewise
};

/// A heading known from elsewhere, at the end of the rest [rad]; sigma 0: exactly.
struct GivenHeading {
  double value = 0, sigma = 0;
};

// Of values made in memory: throws Error for columns of different lengths, times that do not ascend, what is not finite, and angles in degrees.
void validate(const Solution& solution);
void validate(const HeightRecord& record);
void validate(const GivenHeading& heading);

/// At the END of the rest. The covariance [rad^2] is that of phi, east-north-up, where C_nb = (I - [phi x]) C_nb of the truth.
struct Alignment {
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

struct FineAlignment {
  Alignment attitude;
  double gyro_noise = 0, accel_noise = 0;  // the densities used
  double base_displacement = 0;            // of the base's own motion, one sigma as estimated by the filter [m]
  double innovation_square = 0;            // mean square of the normalized innovations; 1 where noise and biases are as stated
  double innovation_correlation = 0;       // of each with the one before; 0 where they are white
  std::size_t updates = 0;                 // their number: both figures scatter by about 1/sqrt(updates)
  Eigen::Vector2d base_velocity;           // at the end of the rest, east and north [m/s]; nothing but noise where the base does not move
  Eigen::Vector3d gyro_bias, accel_bias;   // estimates of the constant errors from the rest, given their covariance
  Eigen::Matrix3d gyro_bias_covariance, accel_bias_covariance;
};

/// A shorter rest is refused (Unsupported) [s].
inline constexpr double shortest_alignment = 10;

/// Analytic: the gyros carry the body axes, the mean specific force of each half of the rest is a direction of gravity there, and the two directions
/// differ by the rotation of the Earth. Sway averages out. The covariance includes noise and biases, but not the base's motion.
/// Throws Error for a place within 0.1 deg of a pole, for a mean force that differs from gravity by more than 5 %, and for a heading of a unit whose
/// forward axis is vertical; Unsupported for a rest that is too short.
Alignment coarse_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                           const std::optional<GivenHeading>& heading = {});

/// Kalman filter about the coarse attitude: the base stays at its place, so the horizontal displacement that the sensors show is an error. The size
/// of the base's motion about its place is estimated where the innovations require it. Biases are states that start from their covariance. Throws as
/// coarse_alignment does, and Unsupported where no motion of a base explains the readings.
FineAlignment fine_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                             const std::optional<GivenHeading>& heading = {});

/// A time without samples.
struct MissingTime {
  double begin = 0, length = 0;  // s
};

enum class GapTreatment { integrate, refuse };

struct AlignedOn {
  FineAlignment alignment;
  double begin = 0, end = 0;  // of the rest [s]
};

/// The start of a navigation, and its end.
struct NavigationStart {
  const NavigationState& state;
  const std::optional<AlignedOn>& aligned;
  double time, end, interval;  // s; of the samples, nominal
};

struct NavigateOptions {
  VerticalChannel vertical = VerticalChannel::free;
  bool align = false;                        // on the first rest, although the session gives an attitude
  std::optional<GivenHeading> heading = {};  // roll and pitch are aligned, the heading is this one
  GapTreatment gaps = GapTreatment::integrate;
  std::optional<HeightRecord> barometer = {};                                            // for the vertical channels aided and held
  std::function<void(const NavigationStart&)> begin = {};                                // called first
  std::function<void(double time, const NavigationState&)> each = {};                    // called with every state as it is reached, the start's too
  std::function<void(double time, const NavigationState&, const Increment&)> step = {};  // called with the increment to every state but the start's
  bool keep = true;  // every state in the solution; otherwise the first and the last
};

/// A less certain heading is refused (Unsupported): the Earth's rate was not resolved.
inline constexpr double largest_heading_sigma = 10 * unit::deg;  // rad

struct Navigated {
  Solution solution;  // from the start, then at every sample's end; or its first and last state
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<AlignedOn> aligned = {};    // absent: started from the session's initial state
  std::vector<MissingTime> gaps = {};       // bridged
  std::size_t saturated = 0;                // samples at a limit among those integrated
  std::vector<NavigationState> track = {};  // some thousand states along the way, for drawings
  std::vector<std::string> warnings = {};
  bool doubtful = false;  // for a reason among the warnings: errors that no uncertainty holds
};

/// `recording` is raw. Starts at the session's initial state, or at the end of the first rest, aligned on it, at the position of the initial state or
/// else of the site. Throws Error where the session has no position or the start lies outside the recording, for missing barometer heights, for gaps
/// that are to be refused and for readings far beyond any motion; Unsupported where there is no rest to align on, or where it does not show the
/// heading. A recording that is moved here is compensated in its place.
Navigated navigate(const Calibration& calibration, const Session& session, Recording recording, const NavigateOptions& options = {});

/// One sigma [rad] of roll, pitch and heading, from an attitude's covariance in east-north-up.
Eigen::Vector3d angle_sigmas(const Alignment& alignment);

/// Solution less truth at one time, east-north-up.
struct NavigationError {
  double time = 0;           // s
  Eigen::Vector3d position;  // m
  Eigen::Vector3d velocity;  // m/s
  Eigen::Vector3d attitude;  // phi [rad]: C_nb = (I - [phi x]) C_nb of the truth; phi_U is the error of the heading

  double horizontal() const { return position.head<2>().norm(); }
};

struct NavigationErrors {
  std::vector<NavigationError> history = {};  // at the times of the coarser of the two, the last one where both last end
  double rate = 0;                            // horizontal error at the end over the time navigated until then [m/s]
  std::vector<std::string> warnings = {};
};

/// Where the times differ the finer of the two is interpolated: position and velocity by the cubic through its positions and velocities (error
/// h^4/384 of the fourth derivative), attitude by the shortest rotation. Throws Error where the times do not overlap.
NavigationErrors navigation_errors(const Solution& solution, const Solution& truth);

}  // namespace imulab
