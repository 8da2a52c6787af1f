// A recording as methods read it that take one column after the other: its columns are in memory, or on disk.
#pragma once

#include "imulab/recording.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The numbers of a recording's columns: x, y, z of each triad.
inline constexpr std::size_t gyro_columns = 0, accel_columns = 3, gyro_temperature_columns = 6, accel_temperature_columns = 9, all_columns = 12;
/// "gyro.x": of a column of readings.
std::string axis_name(std::size_t column);

/// Columns that are not in memory.
class ColumnSource {
 public:
  virtual ~ColumnSource() = default;
  virtual bool has(std::size_t column) const = 0;
  /// The samples of a range, which replace the contents of the buffer. Throws Error where they cannot be read.
  virtual void read(std::size_t column, const Range& range, std::vector<double>& buffer) const = 0;
};

/// Fields and methods as Recording's, which has to outlive it.
class RecordingView {
 public:
  RecordingView() = default;
  RecordingView(const Recording& recording);  // a Recording is one

  std::string_view name;
  double interval_s = 0;
  std::span<const std::int64_t> time_ns;
  std::string_view gyro_unit, accel_unit;
  std::span<const std::size_t> saturated, gaps;
  std::array<std::span<const double>, all_columns> columns;  ///< in memory
  const ColumnSource* on_disk = nullptr;                     ///< in their place, if any

  std::size_t size() const { return time_ns.size(); }
  double time_s(std::size_t i) const { return 1e-9 * static_cast<double>(time_ns[i]); }
  Range samples_in(double begin_s, double end_s) const;
  std::size_t saturated_in(const Range& range) const;
  std::size_t gaps_in(const Range& range) const;

  bool has(std::size_t column) const { return on_disk != nullptr ? on_disk->has(column) : !columns[column].empty(); }
  /// In memory, or read into the buffer; valid as long as both.
  std::span<const double> samples(std::size_t column, const Range& range, std::vector<double>& buffer) const;
};

/// Calls `each`(samples) with one block of a column after the other, each of `block` samples but the last: little memory, wherever the column is.
template <class Each>
void for_each_block(const RecordingView& recording, std::size_t column, const Range& range, std::size_t block, const Each& each) {
  std::vector<double> buffer;
  for (std::size_t begin = range.begin; begin < range.end; begin += block)
    each(recording.samples(column, {begin, std::min(range.end, begin + block)}, buffer));
}
inline constexpr std::size_t usual_block = 65536;

/// The parts of a range between its gaps of at least `shortest_gap_s` and its saturated samples.
std::vector<Range> without_interruptions(const RecordingView& recording, Range range, double shortest_gap_s = 0);

/// The longest of them; empty for an empty range.
Range longest_piece(const RecordingView& recording, const Range& range);

/// When the interval of a gyro sample begins [s].
double start_of_sample(const Recording& recording, std::size_t i);

/// The samples that cover [begin, end]; empty where the recording does not, or is interrupted.
Range samples_covering(const Recording& recording, double begin_s, double end_s);

}  // namespace imulab
