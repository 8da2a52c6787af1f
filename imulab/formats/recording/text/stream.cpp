#include "imulab/formats/recording/text/stream.hpp"

#include "imulab/error.hpp"
#include "imulab/recording/readings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <unistd.h>
#include <utility>

namespace imulab {

using namespace recording_io;

namespace {

constexpr std::size_t block_bytes = 1 << 16, longest_bytes = 1 << 20;  // read at once; of one line, or of what stands before the first row

/// All columns of a recording in one text.
RecordingSource in_one_text(RecordingSource source, const std::string& name) {
  const auto add = [](auto& part) { part.file.reset(), part.topic.reset(), part.time.reset(); };
  source.file = name;
  add(source.gyro), add(source.accel);
  if (source.gyro_temperature) add(*source.gyro_temperature);
  if (source.accel_temperature) add(*source.accel_temperature);
  return source;
}

}  // namespace

RecordingStream::RecordingStream(int descriptor, std::string name, const RecordingSource& source, std::function<void(std::string_view)> copy,
                                 bool interruptible)
    : descriptor_(descriptor),
      name_(std::move(name)),
      source_(in_one_text(source, name_)),
      copy_(std::move(copy)),
      rewriter_({name_, source.topic, source.layout}),
      interruptible_(interruptible) {
  for (const auto* triad : {&source.gyro, &source.accel}) {
    if (triad->file && *triad->file != source.file)
      throw Error(fmt::format("{}: the session has a triad in a file of its own ({}); expected all columns in one text", name_, *triad->file));
    if (triad->topic && *triad->topic != source.topic)
      throw Error(fmt::format("{}: the session has a triad in a topic of its own ({}); expected all columns in one text", name_, *triad->topic));
    if (triad->output == Output::increment && !source.rate_hz)
      throw Error(fmt::format("{}: increments need rate_hz; expected it in the session, since the median interval is known only at the end", name_));
  }
  parts_ = requested_parts(source_);
}

/// Reads on, waiting for something; false at the end.
bool RecordingStream::fill() {
  if (text_.size() > longest_bytes)
    throw Error(
        fmt::format("{}:{}: more than {} bytes without a row; expected lines of numbers", name_, reader_ ? reader_->line() + 1 : 1, longest_bytes));
  std::string bytes(block_bytes, '\0');
  ssize_t count = 0;
  do {
    count = ::read(descriptor_, bytes.data(), block_bytes);
  } while (count < 0 && errno == EINTR);
  if (count < 0) throw Error(fmt::format("{}: cannot be read: {}", name_, std::strerror(errno)));
  bytes.resize(static_cast<std::size_t>(count));
  if (copy_) copy_(bytes);
  if (recognized_) {
    rewriter_.add(bytes, count == 0, text_);
  } else {
    head_ += bytes;
    recognize(count == 0);
  }
  return count > 0;
}

/// Finds out how the text is written, by whole lines, and rewrites what has come of it.
void RecordingStream::recognize(bool ended) {
  const bool complete = ended || head_.size() > longest_bytes;
  recognized_ = rewriter_.start(complete ? head_ : std::string_view(head_).substr(0, head_.find_last_of("\n\r") + 1), complete);
  if (recognized_) rewriter_.add(std::exchange(head_, {}), ended, text_);
}

/// Finds the layout, where the first row has come.
bool RecordingStream::start() {
  if (reader_) return true;
  if (!recognized_) return false;
  const std::string_view lines(text_.data(), ended_ ? text_.size() : text_.rfind('\n') + 1);
  const bool named = names_a_column(source_.time, parts_.requests.front().columns);
  auto layout = ended_ ? table_layout(name_, lines, named, rewriter_.hints()) : find_layout(name_, lines, named, false, rewriter_.hints());
  if (!layout) return false;
  const std::size_t offset = layout->offset;
  const bool settled = layout->settled;
  try {
    reader_.emplace(*std::move(layout), source_.time, source_.rate_hz, parts_.requests.front().columns);
  } catch (const Error&) {
    if (settled) throw;
    return false;  // what has come so far may be a device's greeting
  }
  reader_->limit_left_out(RowReader::Leaves::few);
  text_.erase(0, offset);
  return true;
}

/// The rows that stand in whole lines; a wrong one ends them, and is kept for the next call.
TableRows RecordingStream::read_rows() {
  TableRows rows;
  rows.columns.resize(reader_->places().size());
  std::string_view lines(text_.data(), ended_ ? text_.size() : text_.rfind('\n') + 1);
  const std::size_t whole = lines.size();
  try {
    while (reader_->next(lines)) {
      rows.time_ns.push_back(reader_->row().time_ns);
      for (std::size_t k = 0; k < rows.columns.size(); ++k) rows.columns[k].numbers.push_back(reader_->row().values[reader_->places()[k]]);
    }
  } catch (const Error&) {
    failure_ = std::current_exception();
  }
  text_.erase(0, whole);
  return rows;
}

std::optional<Recording> RecordingStream::next() {
  while (true) {
    if (failure_) std::rethrow_exception(failure_);
    if (start()) {
      parts_.tables.assign(1, read_rows());
      if (!parts_.reference().time_ns.empty()) {
        Readings readings = take_readings(parts_, source_);
        Recording recording = convert_readings(std::move(readings.gyro), std::move(readings.accel), std::move(readings.options));
        recording.time_ns = std::move(parts_.reference().time_ns);
        count(recording);
        return recording;
      }
    }
    if (failure_) continue;
    if (ended_) return std::nullopt;
    ended_ = !fill();
    if (ended_ && interruptible_ && reader_) cut_ = !text_.empty(), text_.clear();
  }
}

void RecordingStream::count(const Recording& block) {
  rows_ += block.size();
  saturated_ += block.saturated.size();
  for (const std::int64_t time_ns : block.time_ns) {
    const double step_s = last_ns_ ? 1e-9 * static_cast<double>(time_ns - *last_ns_) : 0;
    if (step_s > 0 && step_s <= 1.5 * block.interval_s) step_sum_s_ += step_s, ++steps_;
    last_ns_ = time_ns;
  }
}

std::vector<std::string> RecordingStream::warnings() const {
  std::vector<std::string> warnings;
  const auto samples = [](std::size_t n) { return fmt::format("{} {}", n, n == 1 ? "sample" : "samples"); };
  if (reader_)
    for (std::string& warning : reader_->left_out_warnings()) warnings.push_back(std::move(warning));
  if (reader_ && reader_->repeated() > 0)
    warnings.push_back(fmt::format("{}: {} row{} equal to the row before dropped", name_, reader_->repeated(), reader_->repeated() == 1 ? "" : "s"));
  if (cut_) warnings.push_back(fmt::format("{}: the last line has no end and was not used", name_));
  if (saturated_ > 0) warnings.push_back(fmt::format("{}: {} at a limit: the true reading lies beyond", name_, samples(saturated_)));
  if (!source_.rate_hz || rows_ < 2) return warnings;
  const bool increments = source_.gyro.output == Output::increment || source_.accel.output == Output::increment;
  const double declared = 1 / *source_.rate_hz, mean = steps_ > 0 ? step_sum_s_ / static_cast<double>(steps_) : 0;
  if (std::abs(mean - declared) > 0.02 * declared || 2 * steps_ < rows_)
    warnings.push_back(fmt::format("{}: rate_hz = {} is declared, but the stamps do not say so{}", name_, *source_.rate_hz,
                                   increments ? fmt::format(": increments were divided by {:.6g} s", declared) : ""));
  return warnings;
}

}  // namespace imulab
