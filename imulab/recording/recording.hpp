// A recording: columns of samples of one IMU on one clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
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
  std::string name;                   ///< the file named in the session
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
  double time_s(std::size_t i) const { return 1e-9 * static_cast<double>(time_ns[i]); }
  /// The interval [s] sample i stands for: nominal for increments, at a gap and at the first sample; else the stamps' difference.
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

}  // namespace imulab
