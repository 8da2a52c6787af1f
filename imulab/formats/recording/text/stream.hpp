// A recording that arrives as text: standard input, a pipe.
#pragma once

#include "imulab/formats/recording/parts.hpp"
#include "imulab/formats/recording/text/csv_rows.hpp"
#include "imulab/formats/recording/text/plain_text.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Reads rows as they arrive, in memory that does not grow. Findings that need the whole recording are not made: gaps, and a rate that was not
/// declared.
class RecordingStream {
 public:
  /// `name` stands for the file in messages. Throws Error where the source is more than one file, or has increments without rate_hz.
  /// `copy` is given the bytes as they come. With `interruptible`, a last line without an end is not used: its last number may be cut.
  RecordingStream(int descriptor, std::string name, const RecordingSource& source, std::function<void(std::string_view)> copy = {},
                  bool interruptible = false);

  /// The rows that have arrived since the last call; waits for at least one; nothing at the end. Throws Error as read_recording does, after the rows
  /// before the wrong one were given.
  std::optional<Recording> next();
  /// At the end: the findings and their consequences.
  std::vector<std::string> warnings() const;

 private:
  bool fill();
  void recognize(bool ended);
  bool start();
  recording_io::TableRows read_rows();
  void count(const Recording& block);

  int descriptor_;
  std::string name_;
  RecordingSource source_;
  std::function<void(std::string_view)> copy_;
  recording_io::RecordingParts parts_;
  std::optional<recording_io::RowReader> reader_;
  recording_io::TextRewriter rewriter_;
  std::string head_;  // bytes, as long as it is not known how they are to be read
  std::string text_;  // plain, not yet read as rows
  bool recognized_ = false;
  bool ended_ = false, interruptible_ = false, cut_ = false;
  std::exception_ptr failure_;
  std::optional<std::int64_t> last_ns_;
  std::size_t rows_ = 0, saturated_ = 0, steps_ = 0;
  double step_sum_s_ = 0;  // of stamps that follow each other within one and a half intervals
};

}  // namespace imulab
