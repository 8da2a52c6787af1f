// A recording from arrays in memory: from a driver, a ROS bag, your own simulation.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The form in which the readings of a triad are given.
struct ReadingOptions {
  std::string unit{};          ///< "rad/s", "deg/s", "deg/h"; "m/s^2", "g"; of increments "rad", "deg"; "m/s"; or "count"; empty: SI
  double counts_per_unit = 1;  ///< number of counts in one `unit`
  bool increment = false;      ///< each reading is the integral over its interval (delta angle, delta velocity)
  std::optional<std::array<BodyAxis, 3>> axes{};   ///< along which body axis each column measures; absent: x, y, z
  std::optional<std::array<double, 2>> limits{};   ///< readings at or beyond them are saturated; as the readings are
  std::vector<std::vector<double>> temperature{};  ///< none, one column for the three axes, or three; degC, K or raw
};

struct RecordingOptions {
  std::string name = "recording";      ///< used in messages
  std::optional<double> interval_s{};  ///< nominal, which increments are divided by; absent: the median difference of the stamps
  ReadingOptions gyro{}, accel{};
};

/// The declaration of a session, without the temperatures.
RecordingOptions recording_options(const RecordingSource& source);

/// The recording of readings `gyro` and `accel` at times `t` [s], each time the end of the interval over which its reading is a mean or an integral.
/// All columns have one length. Readings become SI (counts stay), increments means; gaps and saturated samples are found. Throws Error for what
/// `validate` refuses, for an unknown unit, and where the interval of increments does not follow from uneven stamps.
Recording make_recording(const std::vector<double>& t, Columns3 gyro, Columns3 accel, RecordingOptions options = {});
/// Makes a recording with exact times [ns].
Recording make_recording(std::vector<std::int64_t> time_ns, Columns3 gyro, Columns3 accel, RecordingOptions options = {});

/// Stamps [s] as whole nanoseconds. Throws Error, naming the sample, for one that is no time.
std::vector<std::int64_t> nanoseconds_of(const std::vector<double>& t, const std::string& name);

/// One column for three axes, three, or none.
Columns3 three_columns(std::vector<std::vector<double>> columns);

/// The readings alone, without stamps, gaps and checks: for pieces of a recording. `interval_s` is used for increments only.
Recording convert_readings(Columns3 gyro, Columns3 accel, RecordingOptions options);

/// Appends samples of such a piece, with their stamps, to a recording that grows.
void append(Recording& all, const Recording& piece, const Range& samples);
/// Findings that need the whole recording: the interval where none is declared, gaps, and channels that clip. `all` is that of `append` alone.
Recording completed(Recording all, const RecordingOptions& options);

}  // namespace imulab
