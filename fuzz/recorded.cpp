// Recordings on their way: a stream against the same bytes as a file, the inspection of a file of which nothing is known, and a bag that is copied
// with its readings replaced.
#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/recording/text/stream.hpp"
#include "imulab/formats/recording/written/compensated_file.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/tasks/inspect.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include "tests/temporary_folder.hpp"
#include <algorithm>
#include <bit>
#include <memory>
#include <optional>
#include <string>
#include <sys/socket.h>
#include <utility>

namespace imulab::fuzz {

namespace {

/// The first byte tells how the rows after it are made.
RecordingSource source_of(unsigned char how, const std::string& file) {
  RecordingSource source;
  source.file = file;
  const bool named = (how & 1) != 0;
  const auto columns = [&](const char* letter, int first) {
    std::vector<Column> three;
    for (int axis = 0; axis < 3; ++axis) three.push_back(named ? Column(std::string(letter) + "xyz"[axis]) : Column(first + axis));
    return three;
  };
  source.gyro.columns = columns("g", 2), source.accel.columns = columns("a", 5);
  if (named) source.time.column = "t";
  source.gyro.unit = "deg/s", source.accel.unit = "m/s^2";
  const int kind = how >> 1 & 7;
  if (kind == 1) source.time.unit = "ms";
  if (kind == 2) source.time.unit = "ns", source.time.zero = 1'700'000'000'000'000'000;
  if (kind == 3) source.time.unit = "us", source.time.wrap_bits = 16;
  if (kind == 4) source.time.unit = "tick", source.time.ticks_per_s = 32768;
  if (kind == 5) source.time.column.reset();
  if (kind == 6) source.time.fraction_column = named ? Column("ns") : Column(8);
  if (kind == 7) source.gyro_temperature.emplace().columns = {named ? Column("tg") : Column(8)};
  if ((how & 16) != 0 || kind == 5) source.rate_hz = 100;
  if ((how & 32) != 0 && source.rate_hz)
    source.gyro.output = source.accel.output = Output::increment, source.gyro.unit = "rad", source.accel.unit = "m/s";
  return source;
}

/// Columns in the order in which a stream has them.
std::vector<Column> columns_of(const RecordingSource& source) {
  std::vector<Column> all = source.gyro.columns;
  all.insert(all.end(), source.accel.columns.begin(), source.accel.columns.end());
  if (source.gyro_temperature) all.insert(all.end(), source.gyro_temperature->columns.begin(), source.gyro_temperature->columns.end());
  return all;
}

struct Outcome {
  Recording rows;
  std::string error;
  bool passed_over = false;  ///< lines before the table, or that are left out behind it
};

Outcome by_file(const std::string& text, RecordingSource source) {
  const FuzzedFile file(text);
  Outcome out;
  try {
    recording_io::TableRows table =
        recording_io::read_table({file.path()}, {.columns = columns_of(source), .time = source.time, .rate_hz = source.rate_hz});
    const auto three = [&](std::size_t first) {
      return Columns3{table.columns[first].numbers, table.columns[first + 1].numbers, table.columns[first + 2].numbers};
    };
    out.rows = convert_readings(three(0), three(3), recording_options(source));
    if (source.gyro_temperature) out.rows.gyro_temperature = three_columns({table.columns[6].numbers});
    out.rows.time_ns = std::move(table.time_ns);
    out.passed_over = !table.warnings.empty();
  } catch (const Error& e) {
    const std::string what = e.what(), name = file.path().string();
    out.error = what.starts_with(name) ? "stream" + what.substr(name.size()) : what;
  }
  return out;
}

/// Packets keep their borders: each read gets one of them.
Outcome by_stream(const std::string& text, const RecordingSource& source) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) != 0) std::abort();
  constexpr std::size_t packets = 60;
  const std::size_t size = std::max<std::size_t>(1, (text.size() + packets - 1) / packets);
  for (std::size_t at = 0; at < text.size(); at += size)
    if (const auto piece = std::min(size, text.size() - at); ::send(ends[0], text.data() + at, piece, MSG_DONTWAIT) != static_cast<ssize_t>(piece))
      std::abort();
  ::close(ends[0]);
  Outcome out;
  try {
    RecordingStream stream(ends[1], "stream", source);
    while (const std::optional<Recording> block = stream.next()) append(out.rows, *block, {0, block->size()});
    out.passed_over = !stream.warnings().empty();
  } catch (const Error& e) {
    out.error = e.what();
  }
  ::close(ends[1]);
  return out;
}

bool same(const Columns3& a, const Columns3& b) {
  const auto equal = [](double x, double y) { return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y); };
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::equal(a[axis].begin(), a[axis].end(), b[axis].begin(), b[axis].end(), equal)) return false;
  return true;
}

}  // namespace

void stream(std::string_view bytes) {
  constexpr std::size_t longest = 30'000;  // what a socket holds
  if (bytes.size() < 2 || bytes.size() > longest) return;
  std::string text(bytes.substr(1));
  for (const RecordingFormat& format : recording_formats())
    if (!format.of_layout && !format.is_text && format.recognizes(text)) return;
  if (text.find('\0') != std::string::npos) return;
  if (text.back() != '\n') text += '\n';  // a file may end inside a row
  const RecordingSource source = source_of(static_cast<unsigned char>(bytes[0]), "stream");
  const Outcome file = by_file(text, source), stream = by_stream(text, source);
  if (file.passed_over && !stream.error.empty())
    return;  // a damaged first row, which a stream takes for the table's begin; or last, which it cannot know
  if (stream.passed_over && !file.error.empty()) return;  // rows left out: only a file knows whether they are few
  if (file.error.empty() != stream.error.empty()) finding(("one of file and stream refuses: " + file.error + stream.error).c_str());
  if (!file.error.empty()) return;
  if (file.rows.time_ns != stream.rows.time_ns) finding("file and stream have different times");
  if (!same(file.rows.gyro, stream.rows.gyro) || !same(file.rows.accel, stream.rows.accel) ||
      !same(file.rows.gyro_temperature, stream.rows.gyro_temperature))
    finding("file and stream have different readings");
}

void inspection(std::string_view bytes) {
  const FuzzedFile file(bytes);
  try {
    inspect_and_read({.files = {file.path().string()}});
  } catch (const Error&) {
  }
  try {
    inspect(signals_of_text("fuzzed", bytes));
  } catch (const Error&) {
  }
}

void rewritten_bag(std::string_view bytes) {
  static const TemporaryFolder folder;
  const char* const kind = bytes.starts_with("#ROSBAG") ? ".bag" : bytes.starts_with("SQLite") ? ".db3" : ".mcap";
  const std::filesystem::path in = folder / (std::string("in") + kind), out = folder / (std::string("out") + kind);
  write_bytes(in, bytes);
  Session session;
  RecordingSource source;
  source.file = in.string();
  source.time.column = "header.stamp", source.time.unit = "ns";
  source.gyro.columns = {"angular_velocity.x", "angular_velocity.y", "angular_velocity.z"}, source.gyro.unit = "rad/s";
  source.accel.columns = {"linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"}, source.accel.unit = "m/s^2";
  CompensatedRecording compensated;
  try {
    compensated.recording = read_recording(session, source).recording;
    for (Columns3* triad : {&compensated.recording.gyro, &compensated.recording.accel})
      for (auto& column : *triad)
        for (double& value : column) value += 0.25;
    write_compensated_bag(out, session, source, compensated);
  } catch (const Error&) {
    return;
  }
  source.file = out.string();
  const Recording again = read_recording(session, source).recording;  // an Error is a finding: what was written reads back
  if (again.time_ns != compensated.recording.time_ns || !same(again.gyro, compensated.recording.gyro) ||
      !same(again.accel, compensated.recording.accel))
    finding("the bag that was written has other readings");
}

}  // namespace imulab::fuzz
