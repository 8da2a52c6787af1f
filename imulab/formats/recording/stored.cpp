#include "imulab/formats/recording/stored.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/checks.hpp"
#include "imulab/formats/recording/parts.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/short_gaps.hpp"
#include "imulab/recording/stamps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace imulab {
namespace {

using namespace recording_io;

/// Copies numbers of a file to another, with samples put in before some of them.
template <class Number, class Read, class Insert>
ColumnFile with_inserted(std::size_t size, std::span<const std::size_t> before, const Read& read, const Insert& insert) {
  ColumnFile out;
  const auto copy = [&](std::size_t begin, std::size_t end) {
    for (; begin < end; begin += usual_block) out.append(std::span<const Number>(read(Range{begin, std::min(end, begin + usual_block)})));
  };
  std::size_t done = 0;
  for (std::size_t gap = 0; gap < before.size(); ++gap) {
    copy(done, before[gap]);
    out.append(std::span<const Number>(insert(gap)));
    done = before[gap];
  }
  copy(done, size);
  return out;
}

std::string why_not_in_pieces(const RecordingFormat& format, const TableRequest& request, const PartRequests& parts, const RecordingSource& source) {
  if (format.rows == nullptr) return fmt::format("{} is read as a whole; expected CSV, .npy or .npz for a log as long as this", format.name);
  if (format.rows(request, parts.tables.front().columns) == 0)
    return "compressed arrays whose columns stand one after the other are read as a whole; expected rows, or arrays that are not compressed";
  if (parts.tables.size() > 1) return "its triads are in several tables, which are read as a whole";
  const bool increments = source.gyro.output == Output::increment || source.accel.output == Output::increment;
  if (increments && !source.rate_hz) return "increments without rate_hz are read as a whole; expected rate_hz in the session";
  return "";
}

/// Without reading what is short anyway.
std::uint64_t rows_of(const RecordingFormat& format, const TableRequest& request, const std::vector<Column>& wanted, std::uint64_t most_bytes) {
  if (const std::size_t rows = format.rows != nullptr ? format.rows(request, wanted) : 0; rows > 0) return rows;
  std::error_code unknown;
  if (std::filesystem::file_size(request.file, unknown) < most_bytes || unknown) return 0;
  std::size_t most = 0;
  for (const TableDescription& table : format.describe(request))
    if (request.topic.empty() || table.name == request.topic) most = std::max(most, table.rows);
  return most;
}

/// Some columns of a piece.
std::vector<std::vector<double>> taken(TimedTable& piece, const PartColumns& which) {
  std::vector<std::vector<double>> out;
  for (const std::size_t c : which.columns) out.push_back(std::move(piece.values[c]));
  return out;
}

/// What the pieces had in common, and their lines.
void add_to(TimedTable& all, std::size_t& rows, const TimedTable& piece) {
  all.file = piece.file;
  all.row = piece.row;
  all.lines.append(piece.lines, rows, 0);
  all.repeated += piece.repeated;
  all.warnings.insert(all.warnings.end(), piece.warnings.begin(), piece.warnings.end());
  rows += piece.time_ns.size();
}

/// A piece in SI or counts.
Recording converted(TimedTable piece, const PartRequests& parts, const RecordingSource& source) {
  RecordingOptions options = recording_options(source);
  options.gyro.temperature = taken(piece, parts.gyro_temperature);
  options.accel.temperature = taken(piece, parts.accel_temperature);
  Columns3 gyro = three_columns(taken(piece, parts.gyro)), accel = three_columns(taken(piece, parts.accel));
  expect_plausible(gyro, options.gyro, Quantity::gyro, options.interval_s.value_or(0), piece);
  expect_plausible(accel, options.accel, Quantity::accel, options.interval_s.value_or(0), piece);
  Recording recording = convert_readings(std::move(gyro), std::move(accel), std::move(options));
  expect_possible_temperature(source.gyro_temperature, recording.gyro_temperature, piece);
  expect_possible_temperature(source.accel_temperature, recording.accel_temperature, piece);
  recording.time_ns = std::move(piece.time_ns);
  return recording;
}

}  // namespace

StoredRecording::StoredRecording(const RecordingSource& source) {
  const auto one_each = [&](std::size_t first) {
    for (std::size_t axis = 0; axis < 3; ++axis) place_[first + axis] = files_.size(), files_.emplace_back();
  };
  place_.fill(none);
  one_each(gyro_columns), one_each(accel_columns);
  for (const auto& [first, thermal] :
       {std::pair{gyro_temperature_columns, &source.gyro_temperature}, std::pair{accel_temperature_columns, &source.accel_temperature}}) {
    if (!*thermal) continue;
    if ((*thermal)->columns.size() == 3) {
      one_each(first);
      continue;
    }
    std::fill_n(place_.begin() + static_cast<std::ptrdiff_t>(first), 3, files_.size());
    files_.emplace_back();
  }
}

void StoredRecording::read(std::size_t column, const Range& range, std::vector<double>& buffer) const {
  if (range.size() > 16 * usual_block) stamps_.release();                    // a whole column: not both in memory
  if (buffer.capacity() < range.size()) std::vector<double>().swap(buffer);  // else both are in memory for a moment
  buffer.resize(range.size());
  files_[place_[column]].read(range.begin, buffer);
}

void StoredRecording::append(const Recording& piece) {
  name_ = piece.name, gyro_unit_ = piece.gyro_unit, accel_unit_ = piece.accel_unit;
  for (const std::size_t i : piece.saturated) saturated_.push_back(stamp_file_.size() + i);
  const RecordingView columns(piece);
  for (std::size_t c = 0, next = 0; c < all_columns; ++c)
    if (place_[c] == next) files_[next++].append(columns.columns[c]);
  stamp_file_.append(columns.time_ns);
}

void StoredRecording::end_of_pieces() { stamps_ = MappedStamps(stamp_file_); }

void StoredRecording::complete(double interval_s, const RecordingOptions& options) {
  interval_s_ = interval_s;
  gaps_ = find_gaps(time_ns(), interval_s_);
  stamps_.release();
  std::vector<bool> clipped(time_ns().size());
  for (const auto& [first, limits] : {std::pair{gyro_columns, options.gyro.limits}, std::pair{accel_columns, options.accel.limits}})
    for (std::size_t axis = 0; axis < 3 && !limits; ++axis)
      for_each_clipped(view(), first + axis, {0, clipped.size()}, [&](std::size_t i) { clipped[i] = true; });
  for (const std::size_t i : saturated_) clipped[i] = true;
  saturated_.clear();
  for (std::size_t i = 0; i < clipped.size(); ++i)
    if (clipped[i]) saturated_.push_back(i);
}

std::size_t StoredRecording::fill_short_gaps() {
  const ShortGaps gaps = short_gaps(view());
  if (gaps.filled == 0) return 0;
  std::vector<double> buffer, inserted;
  for (std::size_t c = 0, next = 0; c < all_columns; ++c) {
    if (place_[c] != next) continue;
    const auto read_samples = [&](const Range& range) -> const std::vector<double>& { return read(c, range, buffer), buffer; };
    files_[next++] = with_inserted<double>(time_ns().size(), gaps_, read_samples, [&](std::size_t gap) -> const std::vector<double>& {
      inserted.clear();
      for (std::size_t k = 1; k <= gaps.counts[gap]; ++k)
        inserted.push_back(filled_sample(std::span<const double>(read_samples({gaps_[gap] - 2, gaps_[gap] + 2})).first<4>(), gaps.counts[gap], k));
      return inserted;
    });
  }
  FilledMarks marks = filled_marks(view(), gaps);
  std::vector<std::int64_t> stamps;
  ColumnFile filled = with_inserted<std::int64_t>(
      time_ns().size(), gaps_, [&](const Range& range) { return time_ns().subspan(range.begin, range.size()); },
      [&](std::size_t gap) -> const std::vector<std::int64_t>& {
        stamps.clear();
        for (std::size_t k = 1; k <= gaps.counts[gap]; ++k)
          stamps.push_back(filled_stamp(time_ns()[gaps_[gap] - 1], time_ns()[gaps_[gap]], gaps.counts[gap], k));
        return stamps;
      });
  stamp_file_ = std::move(filled);
  stamps_ = MappedStamps(stamp_file_);
  gaps_ = std::move(marks.gaps), saturated_ = std::move(marks.saturated);
  return gaps.filled;
}

RecordingView StoredRecording::view() const {
  RecordingView v;
  v.name = name_;
  v.interval_s = interval_s_;
  v.time_ns = time_ns();
  v.gyro_unit = gyro_unit_, v.accel_unit = accel_unit_;
  v.saturated = saturated_, v.gaps = gaps_;
  v.on_disk = this;
  return v;
}

std::optional<StoredReading> read_stored(const Session& session, const RecordingSource& source, std::uint64_t most_bytes, std::string& why,
                                         const std::vector<RecordingFormat>& formats) {
  const PartRequests parts = part_requests(source);
  const PartRequest& table = parts.tables.front();
  const TableRequest request{session_path(session, table.file), table.topic, source.layout};
  const RecordingFormat& format = format_of(request, formats);
  const std::uint64_t bytes = 8 * (table.columns.size() + 1) * rows_of(format, request, table.columns, most_bytes);
  if (bytes <= most_bytes) return std::nullopt;
  if (const std::string reason = why_not_in_pieces(format, request, parts, source); !reason.empty()) {
    why = fmt::format("{}: its columns take {:.2g} GB, the analysis two to three times as much memory: {}", request.file.string(),
                      1e-9 * static_cast<double>(bytes), reason);
    return std::nullopt;
  }
  expect_room(bytes + bytes / 10);
  StoredReading reading{StoredRecording(source), {}};
  TimedTable all;
  std::size_t rows = 0;
  read_table_in_pieces(request, table.time, source.rate_hz, table.columns, format, [&](TimedTable&& piece) {
    add_to(all, rows, piece);
    reading.recording.append(converted(std::move(piece), parts, source));
  });
  reading.recording.end_of_pieces();
  reading.warnings = all.warnings;
  warn_of_repeated(all, reading.warnings);
  const double interval_s = nominal_interval_s(reading.recording.time_ns(), all.file, source, reading.warnings);
  reading.recording.complete(interval_s, recording_options(source));
  const RecordingView view = reading.recording.view();
  warn_of_rate(source, view, all, reading.warnings);
  warn_of_gaps(view, all, session.steps_of(source), reading.warnings);
  warn_of_saturated(view, all, reading.warnings);
  reading.recording.let_go();
  return reading;
}

}  // namespace imulab
