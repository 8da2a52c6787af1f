// Inertial navigation: alignment at rest and strapdown integration on the WGS-84 ellipsoid in east-north-up axes, for single samples or a recording
// with its calibration (docs/theory/strapdown.md).
//
//   C_nb' = C_nb [w_ib_b x] - [w_in_n x] C_nb,   v' = C_nb f_b + g(L, h) - (2 w_ie + w_en) x v,   L' = vN / (RM + h), ...
//
// Example:
//   Strapdown navigator(NavigationState{.latitude = 45 * unit::deg}, {.vertical = VerticalChannel::fixed});
//   navigator.step(Increment{.angle = {0, 0, 1e-4}, .velocity = {0, 0, 0.0981}}, 0.01);
//   std::printf("%g\n", navigator.state().latitude);  // rad
//   const Navigated drive = navigate(calibration, session, recording, {.vertical = VerticalChannel::fixed});
//
// Body axes are right, forward, up. Latitudes are limited to 89.9 deg, and rests for alignment must last at least 10 s. A constant east gyro error e
// causes a heading error of e / (w_ie cos L), a constant accelerometer error b a tilt of b / g; the covariance of an alignment includes both. Savage
// 1998, doi:10.2514/2.4228 and 10.2514/2.4242. Throws Error for an impossible start or impossible readings, and Unsupported if a rest does not
// determine the heading. Only one thread at a time may use a Strapdown.
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

/// Integrals over one interval in body axes, of the angular rate [rad] and of the specific force [m/s].
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

// Attitude angles: roll, pitch and heading of the body axes (right, forward, up) relative to east, north, up.

struct EulerAngles {
  double roll = 0;     // positive with the right side down [rad]
  double pitch = 0;    // positive with the nose up [rad]
  double heading = 0;  // clockwise from north [rad]
};

/// Returns C_nb, the rotation from body axes to east-north-up.
Eigen::Matrix3d attitude_matrix(const EulerAngles& angles);

/// Returns the angles of an attitude: roll and heading in (-pi, pi], pitch in [-pi/2, pi/2]. At a pitch of 90 deg, roll is zero.
EulerAngles euler_angles(const Eigen::Matrix3d& C_nb);

struct NavigationState {
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  // rotation from body axes to east-north-up
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        // relative to the Earth, east-north-up [m/s]
  double latitude = 0, longitude = 0;                        // geodetic [rad]
  double height = 0;                                         // above the ellipsoid [m]
};

/// Barometer heights [m] at times [s].
struct HeightRecord {
  std::vector<double> time, height;
};

struct StrapdownOptions {
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<double> gravity = {};    // constant gravity, straight down [m/s^2]; absent: WGS-84 normal gravity at each position
  double barometer_time_constant = 100;  // time constant of the loop's three poles [s]
  double latitude_limit = 1.5690509975;  // 89.9 deg [rad]; Error beyond, because the axes turn too fast near a pole
  bool previous_sample = true;           // uses the previous sample to compute coning and sculling of a single sample
};

/// The integration: a state, and the values that one step hands to the next.
class Strapdown {
 public:
  /// Starts at `start`. Throws Error if the start is not finite, its quaternion does not have unit length or its latitude is beyond the limit, and if
  /// an option is out of range.
  explicit Strapdown(const NavigationState& start, const StrapdownOptions& options = {});

  /// Integrates one sample over `interval` [s]. `barometer` is the height [m] at the end of the step, for the vertical channels aided and held.
  /// Throws Error if the interval is not positive or the latitude exceeds the limit.
  void step(const Increment& sample, double interval, std::optional<double> barometer = {});
  /// Integrates one to five `samples` over a total `interval` [s]; `barometer` as above.
  void step(std::span<const Increment> samples, double interval, std::optional<double> barometer = {});

  const NavigationState& state() const { return state_; }

 private:
  void advance(const integration::BodyStep& body, double interval);
  void aid(double barometer, double interval);

  NavigationState state_;
  StrapdownOptions options_;
  LocalEarth earth_;                        // at the middle of the last step
  Eigen::Vector3d slow_;                    // gravity and Coriolis acceleration at that time [m/s^2]
  std::optional<Increment> previous_ = {};  // last single sample
  bool lacking_ = false;                    // that sample was the first, integrated without a previous one
  double barometer_integral_ = 0;           // integral of height minus barometer, times its gain [m/s^2]
};

// Attitude, velocity and position over time: a navigation result, or a reference for comparison.

struct Solution {
  std::vector<double> time = {};  // s, ascending
  std::vector<NavigationState> states = {};
  std::size_t size() const { return time.size(); }
};

struct AlignmentSite {
  double latitude = 0;  // at most 89.9 deg north or south [rad]
  double gravity = 0;   // m/s^2
};

/// Sensor errors: the covariances of constant errors in body axes, and white noise densities.
struct AlignmentSensors {
  Eigen::Matrix3d gyro_bias = Eigen::Matrix3d::Zero();   // (rad/s)^2
  Eigen::Matrix3d accel_bias = Eigen::Matrix3d::Zero();  // (m/s^2)^2
  std::optional<double> gyro_noise = {};                 // rad/s/sqrt(Hz); absent: estimated from the rest
  std::optional<double> accel_noise = {};                // m/s^2/sqrt(Hz); likewise
};

/// A heading [rad] from another source, at the end of the rest. sigma 0 means exact.
struct GivenHeading {
  double value = 0, sigma = 0;
};

// These functions throw Error for columns of different lengths, times that do not ascend, values that are not finite, and angles in degrees.
void validate(const Solution& solution);
void validate(const HeightRecord& record);
void validate(const GivenHeading& heading);

/// The attitude at the END of the rest. The covariance [rad^2] is that of phi (east-north-up) in C_nb = (I - [phi x]) C_nb_true.
struct Alignment {
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

struct FineAlignment {
  Alignment attitude;
  double gyro_noise = 0, accel_noise = 0;  // densities that were used
  double base_displacement = 0;            // displacement of the base, one sigma as estimated by the filter [m]
  double innovation_square = 0;            // mean square of the normalized innovations; 1 if noise and biases are as stated
  double innovation_correlation = 0;       // correlation of successive innovations; 0 if they are white
  std::size_t updates = 0;                 // number of updates: both figures scatter by about 1/sqrt(updates)
  Eigen::Vector2d base_velocity;           // at the end of the rest, east and north [m/s]; only noise if the base does not move
  Eigen::Vector3d gyro_bias, accel_bias;   // constant errors estimated from the rest, given their covariance
  Eigen::Matrix3d gyro_bias_covariance, accel_bias_covariance;
};

/// Shortest permitted rest [s]; a shorter one is refused (Unsupported).
inline constexpr double shortest_alignment = 10;

/// Analytic alignment. The gyros propagate the body axes. The mean specific force of each half of the rest gives a direction of gravity, and the two
/// directions differ by the rotation of the Earth. Sway averages out. The covariance includes noise and biases, but not the motion of the base.
/// `rest`: successive increments in body axes; `site`: its latitude and gravity; `sensors`: errors of gyros and accelerometers; `heading`: replaces
/// the heading from the Earth's rate. Throws Error within 0.1 deg of a pole, for a mean force that differs from gravity by more than 5 %, and for a
/// heading if the forward axis is vertical; throws Unsupported if the rest is too short.
Alignment coarse_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                           const std::optional<GivenHeading>& heading = {});

/// Kalman filter about the coarse attitude. The base stays at its position, so every computed horizontal displacement is an error. The size of the
/// base's motion is estimated if the innovations require it. Biases are states that start from their covariance. Parameters as for coarse_alignment.
/// Throws as coarse_alignment does, and Unsupported if no motion of the base explains the readings.
FineAlignment fine_alignment(std::span<const TimedIncrement> rest, const AlignmentSite& site, const AlignmentSensors& sensors,
                             const std::optional<GivenHeading>& heading = {});

/// A time without samples [s].
struct MissingTime {
  double begin = 0, length = 0;  // s
};

enum class GapTreatment { integrate, refuse };

struct AlignedOn {
  FineAlignment alignment;
  double begin = 0, end = 0;  // times of the rest [s]
};

/// Start and end of a navigation.
struct NavigationStart {
  const NavigationState& state;
  const std::optional<AlignedOn>& aligned;
  double time, end, interval;  // [s]; the interval is the nominal sample interval
};

struct NavigateOptions {
  VerticalChannel vertical = VerticalChannel::free;
  bool align = false;                        // aligns on the first rest even if the session gives an attitude
  std::optional<GivenHeading> heading = {};  // replaces the aligned heading; roll and pitch are aligned
  GapTreatment gaps = GapTreatment::integrate;
  std::optional<HeightRecord> barometer = {};                                            // for the vertical channels aided and held
  std::function<void(const NavigationStart&)> begin = {};                                // called first
  std::function<void(double time, const NavigationState&)> each = {};                    // called with every state in order, including the start
  std::function<void(double time, const NavigationState&, const Increment&)> step = {};  // called with the increment to each state but the start
  bool keep = true;  // keeps every state in the solution; otherwise only the first and the last
};

/// Largest permitted sigma of the heading: beyond it the Earth's rate was not resolved, and the alignment is refused (Unsupported).
inline constexpr double largest_heading_sigma = 10 * unit::deg;  // rad

struct Navigated {
  Solution solution;  // the start, then the end of each sample; or the first and last state only
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<AlignedOn> aligned = {};    // absent: the start is the session's initial state
  std::vector<MissingTime> gaps = {};       // bridged gaps
  std::size_t saturated = 0;                // number of integrated samples at a limit
  std::vector<NavigationState> track = {};  // some thousand states at equal intervals, for drawings
  std::vector<std::string> warnings = {};
  bool doubtful = false;  // a warning names an error that the uncertainties do not cover
};

/// Navigates with the raw `recording`, compensated by `calibration`; `session` gives start or site, and the rests. The start is the session's initial
/// state, or the end of the first rest after alignment on it, at the position of the initial state or else of the site. Throws Error if the session
/// has no position, the start is outside the recording, barometer heights are missing, gaps are to be refused, or readings are implausible; throws
/// Unsupported if there is no rest for alignment or it does not determine the heading. A recording that is moved into the call is compensated in
/// place.
Navigated navigate(const Calibration& calibration, const Session& session, Recording recording, const NavigateOptions& options = {});

/// Returns the standard deviations [rad] of roll, pitch and heading, from the covariance of an attitude in east-north-up.
Eigen::Vector3d angle_sigmas(const Alignment& alignment);

/// Solution minus truth at one time, east-north-up.
struct NavigationError {
  double time = 0;           // s
  Eigen::Vector3d position;  // m
  Eigen::Vector3d velocity;  // m/s
  Eigen::Vector3d attitude;  // phi [rad]: C_nb = (I - [phi x]) C_nb_true; phi_U is the heading error

  double horizontal() const { return position.head<2>().norm(); }
};

struct NavigationErrors {
  std::vector<NavigationError> history = {};  // at the times of the coarser solution, the last one when both have ended
  double rate = 0;                            // horizontal error at the end divided by the navigated time [m/s]
  std::vector<std::string> warnings = {};
};

/// Compares a solution with the truth. If times differ, the one with shorter intervals is interpolated: position and velocity by the cubic through
/// positions and velocities (error h^4/384 of the fourth derivative), attitude by the shortest rotation. Throws Error if no times overlap.
NavigationErrors navigation_errors(const Solution& solution, const Solution& truth);

}  // namespace imulab
