#include "imulab/formats/recording/stored.hpp"

#include "imulab/recording/clipping.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/outliers.hpp"
#include "imulab/recording/resampling.hpp"

#include <algorithm>
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

/// Copies the numbers of a file to another but for those of some samples.
template <class Number, class Read>
ColumnFile with_left_out(std::size_t size, const std::vector<std::size_t>& samples, const Read& read) {
  ColumnFile out;
  std::vector<Number> kept;
  std::size_t next = 0;
  for (std::size_t begin = 0; begin < size; begin += usual_block) {
    const Range block{begin, std::min(size, begin + usual_block)};
    const std::span<const Number> numbers = read(block);
    kept.clear();
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (next < samples.size() && samples[next] == begin + i)
        ++next;
      else
        kept.push_back(numbers[i]);
    }
    out.append(std::span<const Number>(kept));
  }
  return out;
}

}  // namespace

StoredRecording::StoredRecording(const RecordingSource& source) {
  const auto one_each = [&](std::size_t first) {
    for (std::size_t axis = 0; axis < 3; ++axis) place_[first + axis] = files_.size(), files_.emplace_back();
  };
  place_.fill(none);
  if (!source.gyro.columns.empty()) one_each(gyro_columns);
  if (!source.accel.columns.empty()) one_each(accel_columns);
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

void StoredRecording::leave_out(const RepeatedRows& repeated) {
  const std::size_t size = time_ns().size();
  std::vector<double> buffer;
  for (std::size_t c = 0, next = 0; c < all_columns; ++c)
    if (place_[c] == next)
      files_[next++] = with_left_out<double>(size, repeated.samples, [&](const Range& range) -> std::span<const double> {
        read(c, range, buffer);
        return buffer;
      });
  Recording marks;  // the stamps and marks alone
  marks.time_ns.assign(time_ns().begin(), time_ns().end());
  marks.saturated = saturated_;
  marks = without_samples(std::move(marks), repeated);
  ColumnFile stamps;
  stamps.append(std::span<const std::int64_t>(marks.time_ns));
  saturated_ = std::move(marks.saturated);
  stamp_file_ = std::move(stamps);
  stamps_ = MappedStamps(stamp_file_);
}

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

std::size_t StoredRecording::replace_outliers() {
  const std::vector<ReplacedReading> outliers = outliers_of(view());
  std::vector<double> buffer;
  for (std::size_t c = 0, next = 0; c < all_columns; ++c) {
    if (place_[c] != next) continue;
    ColumnFile& file = files_[next++];
    if (std::ranges::find(outliers, c, &ReplacedReading::column) == outliers.end()) continue;
    ColumnFile replaced;
    auto outlier = outliers.begin();
    for (std::size_t begin = 0; begin < time_ns().size(); begin += usual_block) {
      const Range block{begin, std::min(time_ns().size(), begin + usual_block)};
      read(c, block, buffer);
      for (; outlier != outliers.end() && outlier->sample < block.end; ++outlier)
        if (outlier->column == c) buffer[outlier->sample - begin] = outlier->value;
      replaced.append(std::span<const double>(buffer));
    }
    file = std::move(replaced);
  }
  const std::vector<std::size_t> samples = samples_of(outliers);
  std::erase_if(saturated_, [&](std::size_t i) { return std::ranges::binary_search(samples, i); });
  return samples.size();
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

}  // namespace imulab
