#include "imulab/formats/recording/format.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <system_error>

namespace imulab {

const std::vector<RecordingFormat>& recording_formats() {
  using namespace recording_io;
  static const std::vector<RecordingFormat> formats{
      ros2_database_format(), mcap_format(), ros1_bag_format(),  numpy_format(),       matlab_format(),
      hdf5_format(),          ulog_format(), dataflash_format(), binary_rows_format(), text_format(),
  };
  return formats;
}

namespace {

/// Throws Error that names the files in it for a folder with the metadata.yaml of a ROS 2 bag.
void expect_no_folder(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored) || !fs::exists(path / "metadata.yaml", ignored)) return;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(path, ignored)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".mcap" || extension == ".db3" || extension == ".zstd") files.push_back(entry.path().filename().string());
  }
  std::sort(files.begin(), files.end());
  std::string listed;
  for (const std::string& file : files) listed += (listed.empty() ? "" : ", ") + (path.filename() / file).string();
  throw Error(fmt::format("{}: is the folder of a ROS 2 bag; expected {}", path.string(),
                          files.empty()       ? "a file in it, but it has none"
                          : files.size() == 1 ? "its file " + listed
                                              : "one of its files, each a recording of its own: " + listed));
}

/// Throws Error that says how to unpack a file that is compressed as a whole, by its first bytes.
void expect_not_packed(const std::filesystem::path& path, std::string_view head) {
  struct Packing {
    std::string_view begin, program;
  };
  static constexpr std::array<Packing, 3> packings{{{"\x28\xB5\x2F\xFD", "zstd -d"}, {"\x1F\x8B", "gunzip"}, {"BZh", "bunzip2"}}};
  for (const auto& [begin, program] : packings)
    if (head.starts_with(begin))
      throw Error(
          fmt::format("{}: is compressed as a whole; expected it unpacked: {}{}", path.string(), program, is_kept(path) ? "" : " " + path.string()));
}

}  // namespace

const RecordingFormat& format_of(const TableRequest& request, const std::vector<RecordingFormat>& formats) {
  expect_no_folder(request.file);
  if (is_stream(request.file))  // it is opened more than once
    throw Error(input_name(request.file) + ": is a pipe or a device; expected a recording that is a file on disk");
  const MappedFile mapped(request.file);
  const std::string_view head = mapped.text().substr(0, 4096);
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) {
    return f.of_layout ? !request.layout.empty() : request.layout.empty() && f.recognizes(head);
  });
  if (format != formats.end() && is_kept(request.file) && !format->is_text)
    throw Error(fmt::format("{}: is {}; expected rows of text, or a file on disk", request.file.string(), format->name));
  if (format != formats.end()) return *format;
  expect_not_packed(request.file, head);
  std::vector<std::string_view> names;
  for (const RecordingFormat& f : formats) names.push_back(f.name);
  throw Error(fmt::format("{}: unknown format; expected {}", request.file.string(), text::listed(names)));
}

}  // namespace imulab
