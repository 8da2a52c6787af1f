// Any bytes as a recording of one format.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/plain_text.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/navigate.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include <algorithm>
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
void archive(std::string_view bytes) { read_all("zip archive", bytes); }
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

}  // namespace imulab::fuzz
