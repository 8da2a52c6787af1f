#include "imulab/formats/recording/bag/folder.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace imulab::bag {

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

}  // namespace imulab::bag
