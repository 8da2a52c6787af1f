// A recording: samples of one IMU on one clock, as columns. It can be made from arrays in memory, a driver, a ROS bag or a simulation.
//
// Example:
//   const Recording mine = make_recording(t, gyro, accel);  // s, rad/s, m/s^2
//   const Recording counts = make_recording(t, gyro, accel, {.gyro = {.unit = "deg/s", .counts_per_unit = 131},
//                                                            .accel = {.unit = "g", .counts_per_unit = 16384, .limits = {{-32768, 32767}}}});
//
// A stamp is the end of the interval over which its reading is a mean (for increments, an integral). Gyro columns precede accelerometer columns, each
// in the order x, y, z. Values become SI, or stay counts if `unit` is "count". Functions throw Error with column, sample and what was expected if
// `validate` refuses the data: columns of unequal length, decreasing stamps, NaN, readings beyond any sensor, or an interval that contradicts the
// stamps. Time and memory are linear in the number of samples. Types are plain values.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace imulab {

using Columns3 = std::array<std::vector<double>, 3>;

/// A half-open range of sample indices.
struct Range {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
  bool operator==(const Range&) const = default;
};

/// Samples as columns. Values are SI if the session names a physical unit, otherwise counts. Increments are divided by the nominal interval, so that
/// all readings are means over the sample's interval.
struct Recording {
  std::string name = "recording";     ///< file name in the session, used in messages
  double interval_s = 0;              ///< nominal interval: 1 / rate_hz, else the median difference of the stamps
  std::vector<std::int64_t> time_ns;  ///< exact end of each sample's interval, nanoseconds since `time.zero`
  Columns3 gyro, accel;
  bool gyro_increment = false, accel_increment = false;
  Columns3 gyro_temperature, accel_temperature;  ///< empty if the session has none; three equal columns if it has one
  std::string gyro_unit = "count", accel_unit = "count";
  std::vector<std::size_t> saturated;  ///< samples with a reading at a limit, ascending
  std::vector<std::size_t> gaps;       ///< samples with missing time before their interval, ascending
  std::vector<std::size_t> starts;     ///< first samples of recordings that were joined to the first one, ascending

  std::size_t size() const { return time_ns.size(); }  ///< number of samples
  /// Returns the memory that the columns occupy.
  std::size_t bytes() const;
  /// Returns the stamp [s] of sample i < size().
  double time_s(std::size_t i) const { return 1e-9 * static_cast<double>(time_ns[i]); }
  /// Returns the interval [s] of sample i: the nominal one for increments, at a gap and at the first sample; else the difference of the stamps.
  /// Throws Error if i is not a sample.
  double interval(std::size_t i, bool increment) const;
  /// Returns true if time is missing before sample i.
  bool follows_gap(std::size_t i) const;

  /// Returns the samples whose nominal interval (stamp - interval_s, stamp] is in [begin_s, end_s] [s]. A tolerance of 1 % of an interval keeps
  /// rounding and small jitter of the stamps from moving a boundary.
  Range samples_in(double begin_s, double end_s) const;
  /// Returns the number of samples in `range` with a reading at a limit.
  std::size_t saturated_in(const Range& range) const;
  /// Returns the number of samples in `range` that follow a gap, including its first sample.
  std::size_t gaps_in(const Range& range) const;
};

/// A body axis with its sign: index 0 to 2, sign +1 or -1.
struct BodyAxis {
  int index = 2, sign = 1;
  bool operator==(const BodyAxis&) const = default;
};

/// The form of a triad's readings.
struct ReadingOptions {
  std::string unit{};          ///< "rad/s", "deg/s", "deg/h"; "m/s^2", "g"; of increments "rad", "deg"; "m/s"; or "count"; empty: SI
  double counts_per_unit = 1;  ///< number of counts in one `unit`
  bool increment = false;      ///< each reading is an integral over its interval (delta angle, delta velocity)
  std::optional<std::array<BodyAxis, 3>> axes{};   ///< body axis along which each column measures; absent: x, y, z
  std::optional<std::array<double, 2>> limits{};   ///< readings at or beyond these limits (in their own unit) are saturated
  std::vector<std::vector<double>> temperature{};  ///< no column, one for the three axes, or three; degC, K or raw
};

struct RecordingOptions {
  std::string name = "recording";      ///< used in messages
  std::optional<double> interval_s{};  ///< nominal interval [s] by which increments are divided; absent: the median difference of the stamps
  ReadingOptions gyro{}, accel{};
};

/// Returns the recording of readings `gyro` and `accel` at times `t` [s], the ends of the intervals over which each reading is a mean or an integral.
/// All columns have equal length. Readings become SI (counts stay), increments become means; gaps and saturated samples are found. Throws Error if
/// `validate` refuses the data, if an option is out of range (unknown unit, axes that are not body axes, counts_per_unit not above 0), or if the
/// interval of increments does not follow from uneven stamps.
Recording make_recording(const std::vector<double>& t, Columns3 gyro, Columns3 accel, RecordingOptions options = {});

/// Exact times in whole nanoseconds. The type distinguishes them from vectors of other integers.
struct Nanoseconds {
  std::vector<std::int64_t> count;
};
/// Makes a recording from exact times.
Recording make_recording(Nanoseconds t, Columns3 gyro, Columns3 accel, RecordingOptions options = {});

/// Converts stamps [s] to whole nanoseconds. `name` is the recording in messages. Throws Error with the sample if a stamp is not a valid time.
std::vector<std::int64_t> nanoseconds_of(const std::vector<double>& t, const std::string& name);
/// Converts std::chrono times to whole nanoseconds, exactly unless they are finer than nanoseconds. Throws Error likewise.
template <class Rep, class Period>
Nanoseconds nanoseconds_of(const std::vector<std::chrono::duration<Rep, Period>>& t, const std::string& name) {
  using Seconds = std::chrono::duration<double>;
  std::vector<double> seconds;
  for (const auto& time : t) seconds.push_back(Seconds(time).count());
  Nanoseconds out{nanoseconds_of(seconds, name)};  // checks that all are valid times
  if constexpr (!std::chrono::treat_as_floating_point_v<Rep>)
    for (std::size_t i = 0; i < t.size(); ++i) out.count[i] = std::chrono::duration_cast<std::chrono::nanoseconds>(t[i]).count();
  return out;
}
/// Makes a recording from std::chrono times, for example std::vector<std::chrono::milliseconds> or durations of doubles.
template <class Rep, class Period>
Recording make_recording(const std::vector<std::chrono::duration<Rep, Period>>& t, Columns3 gyro, Columns3 accel, RecordingOptions options = {}) {
  return make_recording(nanoseconds_of(t, options.name), std::move(gyro), std::move(accel), options);
}

/// Throws Error with column, sample and what was expected for: no samples; columns whose length differs from the stamps'; stamps that decrease or
/// repeat; a reading or temperature that is NaN or infinite; a reading beyond largest_reading; units other than "count", "rad/s" (gyro) and "m/s^2"
/// (accel); an interval that is not positive or differs from the stamps' differences outside gaps by more than 2 % (in median and mean); gaps or
/// saturated samples that are out of range or not ascending. Needs one pass over the columns.
void validate(const Recording& recording);

}  // namespace imulab
