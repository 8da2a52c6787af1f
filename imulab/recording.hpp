// A recording: columns of samples of one IMU on one clock; made of arrays in memory, from a driver, a ROS bag, your own simulation.
//
// Example:
//   const Recording mine = make_recording(t, gyro, accel);  // s, rad/s, m/s^2
//   const Recording counts = make_recording(t, gyro, accel, {.gyro = {.unit = "deg/s", .counts_per_unit = 131},
//                                                            .accel = {.unit = "g", .counts_per_unit = 16384, .limits = {{-32768, 32767}}}});
//
// A stamp is the end of the interval over which its reading is a mean (or, of increments, an integral). Columns are gyro before accel, x y z. Values
// become SI, or stay counts, where `unit` is "count". Throws Error, which names column, sample and what was expected, for what `validate` refuses:
// columns of unequal length, stamps that go back, NaN, readings beyond any sensor, an interval that contradicts the stamps. Time and memory are
// linear in the number of samples. A plain value.
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

/// Half-open range of sample indices.
struct Range {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
  bool operator==(const Range&) const = default;
};

/// Samples as columns. Values are in SI where the session names a physical unit, in counts otherwise; an increment output is divided by the
/// nominal interval, so that both kinds of output are means over the sample's interval.
struct Recording {
  std::string name = "recording";     ///< the file named in the session; used in messages
  double interval_s = 0;              ///< nominal interval: 1 / rate_hz, else the median difference of the stamps
  std::vector<std::int64_t> time_ns;  ///< end of each sample's interval, nanoseconds since `time.zero`: exact
  Columns3 gyro, accel;
  bool gyro_increment = false, accel_increment = false;
  Columns3 gyro_temperature, accel_temperature;  ///< empty where the session has none; three equal columns where it has one
  std::string gyro_unit = "count", accel_unit = "count";
  std::vector<std::size_t> saturated;  ///< samples with a reading at a limit, ascending
  std::vector<std::size_t> gaps;       ///< samples whose interval does not begin at the sample before: time is missing there, ascending
  std::vector<std::size_t> starts;     ///< of recordings that were joined to the first one: first samples, ascending

  std::size_t size() const { return time_ns.size(); }
  /// The memory that its columns take.
  std::size_t bytes() const;
  /// As an element of a vector: i < size().
  double time_s(std::size_t i) const { return 1e-9 * static_cast<double>(time_ns[i]); }
  /// The interval [s] sample i stands for: nominal for increments, at a gap and at the first sample; else the stamps' difference. Throws Error for a
  /// sample that there is not.
  double interval(std::size_t i, bool increment) const;
  /// True if time is missing before sample i.
  bool follows_gap(std::size_t i) const;

  /// The samples whose nominal interval (stamp - interval_s, stamp] lies inside [begin_s, end_s]; a hundredth of an interval outside still counts as
  /// inside, so that rounding and small jitter of the stamps move no boundary.
  Range samples_in(double begin_s, double end_s) const;
  /// The number of samples of a range with a reading at a limit.
  std::size_t saturated_in(const Range& range) const;
  /// The number of samples of a range that follow a gap, its first one included.
  std::size_t gaps_in(const Range& range) const;
};

/// A body axis with its sign: index 0..2, sign +1 or -1.
struct BodyAxis {
  int index = 2, sign = 1;
  bool operator==(const BodyAxis&) const = default;
};

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

/// The recording of readings `gyro` and `accel` at times `t` [s], each time the end of the interval over which its reading is a mean or an integral.
/// All columns have one length. Readings become SI (counts stay), increments means; gaps and saturated samples are found. Throws Error for what
/// `validate` refuses, for options out of range (an unknown unit, axes that are no body axes, a number of counts that is not above 0), and where the
/// interval of increments does not follow from uneven stamps.
Recording make_recording(const std::vector<double>& t, Columns3 gyro, Columns3 accel, RecordingOptions options = {});

/// Exact times as whole nanoseconds, by name: a vector of plain integers could be of anything.
struct Nanoseconds {
  std::vector<std::int64_t> count;
};
/// As above, with exact times.
Recording make_recording(Nanoseconds t, Columns3 gyro, Columns3 accel, RecordingOptions options = {});

/// Stamps [s] as whole nanoseconds. Throws Error, naming the sample, for one that is no time.
std::vector<std::int64_t> nanoseconds_of(const std::vector<double>& t, const std::string& name);
/// Times of std::chrono as whole nanoseconds: exact for all that are no coarser than nanoseconds. Throws Error, naming the sample, for one that is no
/// time.
template <class Rep, class Period>
Nanoseconds nanoseconds_of(const std::vector<std::chrono::duration<Rep, Period>>& t, const std::string& name) {
  using Seconds = std::chrono::duration<double>;
  std::vector<double> seconds;
  for (const auto& time : t) seconds.push_back(Seconds(time).count());
  Nanoseconds out{nanoseconds_of(seconds, name)};  // whether all are times
  if constexpr (!std::chrono::treat_as_floating_point_v<Rep>)
    for (std::size_t i = 0; i < t.size(); ++i) out.count[i] = std::chrono::duration_cast<std::chrono::nanoseconds>(t[i]).count();
  return out;
}
/// As above, with times of std::chrono: std::vector<std::chrono::milliseconds>, of microseconds, of durations of doubles, ...
template <class Rep, class Period>
Recording make_recording(const std::vector<std::chrono::duration<Rep, Period>>& t, Columns3 gyro, Columns3 accel, RecordingOptions options = {}) {
  return make_recording(nanoseconds_of(t, options.name), std::move(gyro), std::move(accel), options);
}

/// Throws Error, naming the column, the sample and what was expected, for: no samples; columns of another length than the stamps; stamps that go back
/// or repeat; a reading or temperature that is NaN or infinite; a reading beyond largest_reading; units other than "count", "rad/s" (gyro) and
/// "m/s^2" (accel); an interval that is not positive, or that differs from the stamps' differences outside gaps by more than 2 % (in median and
/// mean); gaps or saturated samples that are out of range or not ascending. One pass over the columns.
void validate(const Recording& recording);

}  // namespace imulab
