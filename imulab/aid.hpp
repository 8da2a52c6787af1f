// Aids of a drive or flight: what a receiver, the wheels, a barometer or a known constraint says of the motion, beside the IMU.
//
// Example:
//   Aid receiver;                                         // kind: gnss
//   receiver.lever_arm = Eigen::Vector3d(0.0, 0.5, 1.2);  // from the IMU, body axes [m]
//   receiver.record.time = {0, 100'000'000};              // ns of the recording's clock
//   receiver.record.position.assign(2, {52 * unit::deg, 13 * unit::deg, 120});
//   session.aids = {receiver};
//
// A session lists them as [[aid]] (docs/reference/aids.md), whose files `read_aids` (files.hpp) reads into records on the recording's clock. Frames:
// east-north-up, body right-forward-up. SI and radians. Plain values.
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
  vehicle,       ///< no file: a body on wheels moves neither sideways nor upward
  wheels,        ///< forward speed
  barometer,     ///< height with a slow error
  heading,       ///< of the forward axis
  zero_velocity  ///< no file: rests found in the recording
};
std::string_view to_string(AidKind kind);
/// False for the kinds without a file.
bool has_record(AidKind kind);

/// What the stamps of a recording or an aid count. own: a clock of its own, whose offset is then estimated; recording: of an aid, exactly the time of
/// the recording. Stamps of an aid in gps or utc are the date and time of day of that scale, as time since 1970 without leap seconds.
enum class TimeScale { own, gps, utc, recording };
std::string_view to_string(TimeScale scale);

/// What an aid measured, one row a stamp. Columns that it does not have are empty; NaN where one row lacks the value, or a component of it (NMEA has
/// no vertical velocity). Standard deviations are as the receiver states them.
struct AidRecord {
  std::vector<std::int64_t> time;               ///< [ns], as stamped: a delay is not taken off; strictly increasing
  std::vector<Eigen::Vector3d> position;        ///< latitude, longitude [rad], height above the ellipsoid [m]
  std::vector<Eigen::Vector3d> position_sigma;  ///< east, north, up [m]
  std::vector<Eigen::Vector3d> velocity;        ///< against the Earth, east, north, up [m/s]
  std::vector<Eigen::Vector3d> velocity_sigma;  ///< east, north, up [m/s]
  std::vector<double> value;                    ///< of wheels [m/s], barometer [m], heading [rad]
  std::vector<double> value_sigma;
  bool operator==(const AidRecord&) const = default;
};

/// From `begin` to `end` [s] of the recording.
struct Outage {
  double begin = 0, end = 0;
  bool operator==(const Outage&) const = default;
};

/// One [[aid]]. Declared values that are absent take the defaults of their kind where they are used.
struct Aid {
  AidKind kind = AidKind::gnss;
  std::string file = {};                               ///< or topic of the recording's log; empty without one
  std::string recording = {};                          ///< file of the one among the session's recordings that it goes with; empty: all
  AidRecord record = {};                               ///< empty in a mission, and for the kinds without a file
  TimeScale scale = TimeScale::own;                    ///< of the record's stamps
  std::optional<Eigen::Vector3d> lever_arm = {};       ///< from the IMU, body axes [m]
  std::optional<double> lever_arm_sigma = {};          ///< [m]
  std::optional<double> delay = {}, delay_sigma = {};  ///< [s]; positive: its stamps are late
  std::optional<double> position_sigma = {};           ///< [m], one axis
  std::optional<double> velocity_sigma = {};           ///< [m/s], one axis
  std::optional<double> value_sigma = {};              ///< of wheels [m/s], barometer [m], heading [rad], or of side slip [m/s]
  std::optional<double> correlation = {};              ///< of its errors [s]
  std::vector<Outage> outages = {};                    ///< withheld, predicted and compared
  std::optional<double> rate = {};                     ///< [Hz]; of a simulation
  std::vector<Outage> jumps = {};                      ///< of a simulation: with positions displaced, as by reflected signals
  std::optional<double> jump = {};                     ///< [m], horizontally
  double other_scale_s = 0;  ///< of a clock of unknown scale that counts from a date: stamps of the other one are so much later
  bool operator==(const Aid&) const = default;
};

/// GPS time less UTC at a time of UTC, as seconds since 1970: 18 s since 2017. Leap seconds: IERS Bulletin C.
int leap_seconds(double utc);

}  // namespace imulab
