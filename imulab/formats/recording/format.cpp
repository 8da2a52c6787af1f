#include "imulab/formats/recording/format.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/text/dialect.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

namespace imulab {

const std::vector<RecordingFormat>& recording_formats() {
  using namespace recording_io;
  static const std::vector<RecordingFormat> formats{
      ros2_database_format(), mcap_format(),         ros1_bag_format(),    split_bag_format(), kitti_oxts_format(), text_folder_format(),
      workbook_format(),      text_archive_format(), numpy_format(),       matlab_format(),    hdf5_format(),       ulog_format(),
      dataflash_format(),     novatel_format(),      binary_rows_format(), text_format(),
  };
  return formats;
}

namespace {

/// The format of a folder, or of names that are joined.
const RecordingFormat& format_of_several(const std::filesystem::path& path, const std::vector<RecordingFormat>& formats) {
  const auto format =
      std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) { return f.recognizes_path != nullptr && f.recognizes_path(path); });
  if (format != formats.end()) return *format;
  throw Error(
      fmt::format("{}: is a folder without a recording that is known here; expected a session.toml, a bag, or tables of text in it", path.string()));
}

/// Throws Error for what navigation takes beside an IMU.
void expect_no_aid(const std::filesystem::path& path, std::string_view head) {
  const std::string_view kind = recording_io::solution_kind(head);
  if (kind.empty()) return;
  throw Error(
      fmt::format("{0}: is a GNSS solution ({1}), an aid of a navigation and no recording; expected the readings of an IMU, and this file beside "
                  "them: imulab inspect log.csv {0} -o session.toml",
                  input_name(path), kind));
}

}  // namespace

std::string_view recording_io::solution_kind(std::string_view head) {
  const auto begins_lines = [&](std::string_view text) {
    return head.starts_with(text) || head.find("\n" + std::string(text)) != std::string_view::npos;
  };
  if (head.starts_with('%') && (begins_lines("%  GPST") || begins_lines("%  UTC") || begins_lines("%  JST"))) return "RTKLIB's .pos";
  bool nmea = head.starts_with("$G");
  for (std::size_t at = head.find('\n'); nmea && at != std::string_view::npos; at = head.find('\n', at + 1))
    nmea = at + 2 >= head.size() || head.substr(at + 1, 2) == "$G" || head[at + 1] == '\r';
  return nmea ? "NMEA 0183" : "";
}

const RecordingFormat& format_of(const TableRequest& request, const std::vector<RecordingFormat>& formats) {
  if (is_several_files(request.file)) return format_of_several(request.file, formats);
  if (is_stream(request.file))  // it is opened more than once
    throw Error(input_name(request.file) + ": is a pipe or a device; expected a recording that is a file on disk");
  const MappedFile mapped(request.file);
  const std::string_view head = mapped.text().substr(0, 4096);
  const bool text = recording_io::is_text_layout(request.layout);
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) {
    return text ? f.is_text && f.open_text == nullptr : f.of_layout ? !request.layout.empty() : request.layout.empty() && f.recognizes(head);
  });
  if (format != formats.end() && is_kept(request.file) && (!format->is_text || format->open_text != nullptr))
    throw Error(fmt::format("{}: is {}; expected rows of text, or a file on disk", request.file.string(), format->name));
  if (format != formats.end() && format->is_text) expect_no_aid(request.file, head);
  if (format != formats.end()) return *format;
  std::vector<std::string_view> names;
  for (const RecordingFormat& f : formats) names.push_back(f.name);
  throw Error(fmt::format("{}: unknown format; expected {}", request.file.string(), text::listed(names)));
}

}  // namespace imulab
