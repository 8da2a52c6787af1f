// Aids of a motion: measurements beside the IMU, from a receiver, wheels, a barometer, a compass, motion capture or a known constraint.
//
// Example:
//   Aid receiver;                                         // kind: gnss
//   receiver.lever_arm = Eigen::Vector3d(0.0, 0.5, 1.2);  // from the IMU, body axes [m]
//   receiver.record.time = {0, 100'000'000};              // ns of the recording's clock
//   receiver.record.position.assign(2, {52 * unit::deg, 13 * unit::deg, 120});
//   session.aids = {receiver};
//
// A session lists aids as [[aid]] (docs/reference/aids.md); `read_aids` (files.hpp) reads their files into records on the recording's clock.
// Navigation axes are east-north-up, body axes right-forward-up. All values are in SI units and radians. The types are plain values.
#pragma once

#include "imulab/eigen.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

enum class AidKind {
  gnss,          ///< position, velocity or both, of an antenna
  vehicle,       ///< constraint without a file: a body on wheels moves neither sideways nor upward
  wheels,        ///< forward speed
  barometer,     ///< height with a slowly varying error
  heading,       ///< heading of the forward axis
  pose,          ///< position and attitude in a frame of its own: motion capture, a robot arm
  attitude,      ///< attitude in a frame of its own
  odometry,      ///< as pose, with errors that grow: visual or lidar odometry
  zero_velocity  ///< constraint without a file: the velocity is zero in rests found in the recording
};
/// Returns the name of `kind` in a session file.
std::string_view to_string(AidKind kind);
/// Returns false if aids of this kind have no file (vehicle, zero_velocity).
bool has_record(AidKind kind);
/// Returns true if aids of this kind measure attitude in a frame of their own (pose, attitude, odometry).
bool has_attitude(AidKind kind);

/// The time scale of the stamps of a recording or an aid. own: an independent clock, whose offset is estimated; recording (aids only): exactly the
/// time of the recording. Stamps in gps or utc are the date and time of day on that scale, counted from 1970 without leap seconds.
enum class TimeScale { own, gps, utc, recording };
std::string_view to_string(TimeScale scale);  ///< returns the name in a session file

/// What is known of the frame of poses. free: nothing; level: its z axis is up; north: its axes are east, north, up.
enum class AidFrame { free, level, north };
std::string_view to_string(AidFrame frame);  ///< returns the name in a session file

/// The measurements of an aid, one row per stamp. A column that the aid lacks is empty; a missing value or component is NaN (NMEA has no vertical
/// velocity). The standard deviations are those that the receiver states.
struct AidRecord {
  std::vector<std::int64_t> time;               ///< [ns], as stamped (the delay is not removed), strictly increasing
  std::vector<Eigen::Vector3d> position;        ///< latitude, longitude [rad], height above the ellipsoid [m]
  std::vector<Eigen::Vector3d> position_sigma;  ///< east, north, up [m]; of poses x, y, z
  std::vector<Eigen::Vector3d> velocity;        ///< against the Earth, east, north, up [m/s]
  std::vector<Eigen::Vector3d> velocity_sigma;  ///< east, north, up [m/s]
  std::vector<double> value;                    ///< value of wheels [m/s], barometer [m] or heading [rad]
  std::vector<double> value_sigma;              ///< of the value; of poses and attitudes that of the attitude, per axis [rad]
  std::vector<Eigen::Vector3d> place;           ///< of poses: x, y, z in the frame of the aid [m]
  std::vector<Eigen::Vector4d> attitude;        ///< quaternion x, y, z, w from the axes of the tracked body to the frame of the aid
  bool operator==(const AidRecord&) const = default;
};

/// A time from `begin` to `end` [s] on the recording's clock.
struct Outage {
  double begin = 0, end = 0;
  bool operator==(const Outage&) const = default;
};

/// One [[aid]]. An absent declared value takes the default of the aid's kind when it is used.
struct Aid {
  AidKind kind = AidKind::gnss;
  std::string file = {};                               ///< file, or topic of the recording's log; empty if the kind has no file
  std::string recording = {};                          ///< file name of the session's recording to which the aid belongs; empty: all
  AidRecord record = {};                               ///< empty in a mission, and for kinds without a file
  TimeScale scale = TimeScale::own;                    ///< time scale of the record's stamps
  std::optional<Eigen::Vector3d> lever_arm = {};       ///< position relative to the IMU, body axes [m]
  std::optional<double> lever_arm_sigma = {};          ///< [m]
  std::optional<double> delay = {}, delay_sigma = {};  ///< [s]; positive: the stamps are late
  std::optional<double> position_sigma = {};           ///< [m], per axis
  std::optional<double> velocity_sigma = {};           ///< [m/s], per axis
  std::optional<double> value_sigma = {};              ///< standard deviation of wheels or side slip [m/s], barometer [m], heading or attitude [rad]
  std::optional<double> correlation = {};              ///< correlation time of the errors [s]
  AidFrame frame = AidFrame::free;                     ///< of poses and attitudes
  bool scale_known = true;                             ///< of poses: their unit is the metre; otherwise their scale is estimated
  std::vector<Outage> outages = {};                    ///< times in which the values are withheld, predicted and compared
  std::optional<double> rate = {};                     ///< [Hz]; used by simulations
  std::vector<Outage> jumps = {};                      ///< simulated times with displaced positions, as by reflected signals
  std::optional<double> jump = {};                     ///< horizontal displacement in these times [m]
  /// For a clock of unknown scale that counts from a date: the leap seconds [s] by which GPS stamps exceed UTC stamps at the start.
  double other_scale_s = 0;
  bool operator==(const Aid&) const = default;
};

/// Returns GPS time minus UTC [s], 18 since 2017, at `utc`, a time of UTC in seconds since 1970. Leap seconds: IERS Bulletin C.
int leap_seconds(double utc);

}  // namespace imulab
