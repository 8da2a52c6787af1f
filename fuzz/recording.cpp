// Any bytes as a recording of one format.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/recording/text/plain_text.hpp"
#include "imulab/navigate.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace imulab::fuzz {

namespace {

const RecordingFormat& format_named(std::string_view part) {
  for (const RecordingFormat& format : recording_formats())
    if (format.name.find(part) != std::string_view::npos) return format;
  std::abort();
}

/// Every table and column, as far as the file gives them.
void read_all(std::string_view format_name, std::string_view bytes) try {
  const RecordingFormat& format = format_named(format_name);
  const FuzzedFile file(bytes);
  TableRequest request{file.path(), "", format.of_layout ? "+16 <f8 u2 x1 >i4x3" : ""};
  for (const auto& table : format.describe(request)) {
    std::vector<Column> columns;
    for (std::size_t i = 0; i < table.columns.size() && i < 16; ++i) columns.emplace_back(static_cast<int>(i) + 1);
    request.topic = table.name;
    try {
      const recording_io::TableRows raw = recording_io::read_columns(request, columns, format);
      if (raw.columns.size() != columns.size()) finding("another number of columns than asked for");
    } catch (const Error&) {
    }
  }
} catch (const Error&) {
}

}  // namespace

void text_table(std::string_view bytes) { read_all("CSV", bytes); }
void numpy(std::string_view bytes) { read_all("NumPy", bytes); }
void matlab(std::string_view bytes) { read_all("MATLAB .mat", bytes); }
void hdf5(std::string_view bytes) { read_all("HDF5", bytes); }
void binary_rows(std::string_view bytes) { read_all("rows", bytes); }
void ulog(std::string_view bytes) { read_all("ULog", bytes); }
void dataflash(std::string_view bytes) { read_all("DataFlash", bytes); }
void novatel(std::string_view bytes) { read_all("NovAtel", bytes); }
void archive(std::string_view bytes) { read_all("archive of texts", bytes); }
void workbook(std::string_view bytes) { read_all("Excel", bytes); }
void ros1(std::string_view bytes) { read_all("ROS 1", bytes); }
void mcap(std::string_view bytes) { read_all("MCAP", bytes); }
void ros2(std::string_view bytes) { read_all("SQLite", bytes); }

/// Any text in any dialect, rewritten as a whole, and piece by piece as a stream is: both give the same.
void dialect(std::string_view bytes) {
  using recording_io::TextRewriter;
  std::string whole, pieces;
  TextRewriter all({"fuzzed"}), some({"fuzzed"});
  try {
    if (!all.start(bytes, true) || !some.start(bytes, true)) finding("a complete text that needs more");
    all.add(bytes, true, whole);
    constexpr std::size_t piece = 37;
    for (std::string_view left = bytes; !left.empty(); left.remove_prefix(std::min(left.size(), piece)))
      some.add(left.substr(0, piece), false, pieces);
    some.add("", true, pieces);
    if (whole != pieces && all.notes().empty()) finding("pieces that are rewritten otherwise than the whole");
    for (const std::string& sensor : all.sensors()) recording_io::TextFile(bytes, {"fuzzed", sensor});
  } catch (const Error&) {
  }
}

void solution(std::string_view bytes) {
  const FuzzedFile file(bytes);
  try {
    read_solution(file.path());
  } catch (const Error&) {
  }
  try {
    read_heights(file.path());
  } catch (const Error&) {
  }
}

/// In every format, recognized or not, as every kind that has a file.
void aids(std::string_view bytes) {
  using namespace aid_io;
  const FuzzedFile file(bytes);
  for (const AidFormat& format : aid_formats())
    for (const AidKind kind : {AidKind::gnss, AidKind::wheels, AidKind::barometer, AidKind::heading, AidKind::pose, AidKind::attitude}) {
      if (format.has_topics && !format.recognizes(bytes.substr(0, 4096))) continue;
      try {
        const AidRecord record = make_record(format.read({file.path(), kind})).record;
        const auto same = [&](std::size_t rows) { return rows == 0 || rows == record.time.size(); };
        if (!std::is_sorted(record.time.begin(), record.time.end(), std::less_equal<>()) || record.time.empty()) finding("stamps that do not ascend");
        if (!same(record.position.size()) || !same(record.velocity.size()) || !same(record.value.size())) finding("columns of different lengths");
        for (const Eigen::Vector3d& position : record.position)
          if (std::abs(position.x()) > 1.6) finding("a latitude beyond the poles");
      } catch (const Error&) {
      }
    }
}

}  // namespace imulab::fuzz
