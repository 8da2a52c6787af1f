// A recording too long for memory: read in pieces, its columns kept in temporary files (docs/evidence/performance.md, "Long recordings").
#pragma once

#include "imulab/formats/recording/column_file.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/repeated_rows.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Columns as a Recording has them. 8 bytes a number are written to the folder for temporary files.
class StoredRecording : public ColumnSource {
 public:
  /// Columns as the source declares them.
  explicit StoredRecording(const RecordingSource& source);

  bool has(std::size_t column) const override { return place_[column] != none; }
  void read(std::size_t column, const Range& range, std::vector<double>& buffer) const override;

  /// Pieces of neighboring samples, as convert_readings gives them, with their stamps; then, once, a finding that needs the whole recording: channels
  /// that clip.
  void append(const Recording& piece);
  void end_of_pieces();
  /// As without_samples, before it is complete.
  void leave_out(const RepeatedRows& repeated);
  void complete(double interval_s, const RecordingOptions& options);
  /// Replaces the outliers (outliers_of), which then do not count as saturated; returns the number of samples.
  std::size_t replace_outliers();
  /// As with_short_gaps_filled; returns the number of samples.
  std::size_t fill_short_gaps();

  /// Releases the memory of stamps that have been examined.
  void let_go() const { stamps_.release(); }

  std::span<const std::int64_t> time_ns() const { return stamps_.stamps(); }
  /// Valid until the recording is moved, filled, or ends.
  RecordingView view() const;

 private:
  static constexpr auto none = static_cast<std::size_t>(-1);
  std::vector<recording_io::ColumnFile> files_;
  std::array<std::size_t, all_columns> place_{};  // in files_
  recording_io::ColumnFile stamp_file_;
  recording_io::MappedStamps stamps_;
  std::string name_, gyro_unit_, accel_unit_;
  double interval_s_ = 0;
  std::vector<std::size_t> saturated_, gaps_;
};

}  // namespace imulab
