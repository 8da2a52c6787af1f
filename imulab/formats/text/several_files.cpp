#include "imulab/formats/text/several_files.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// What files of a recording are called. All else, above all pictures, is neither read nor summed.
constexpr std::array<std::string_view, 14> read_extensions{".csv", ".tsv",  ".txt", ".dat", ".log", ".json", ".yaml",
                                                           ".yml", ".mcap", ".db3", ".bag", ".xml", ".zstd", ".imu"};
constexpr std::array<std::string_view, 3> bag_extensions{".bag", ".mcap", ".db3"};

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

template <std::size_t N>
bool has_extension(const fs::path& file, const std::array<std::string_view, N>& known) {
  return std::find(known.begin(), known.end(), lower_extension(file)) != known.end();
}

/// The parts that a name joins; empty where one of them is not there.
std::vector<fs::path> joined_parts(const fs::path& recording) {
  std::error_code none;
  const std::string name = recording.filename().string();
  if (name.find('+') == std::string::npos || fs::exists(recording, none)) return {};
  std::vector<fs::path> parts;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('+', begin), name.size());
    parts.push_back(recording.parent_path() / name.substr(begin, end - begin));
    if (!fs::is_regular_file(parts.back(), none)) return {};
    begin = end + 1;
  }
  return parts;
}

std::vector<fs::path> files_below(const fs::path& folder) {
  constexpr std::size_t most_entries = 1'000'000, most_files = 100'000;
  std::vector<fs::path> files;
  std::size_t entries = 0;
  std::error_code failure;
  for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, failure), end; !failure && at != end;
       at.increment(failure)) {
    std::error_code none;
    if (has_extension(at->path(), read_extensions) && at->is_regular_file(none)) files.push_back(at->path());
    if (++entries > most_entries || files.size() > most_files)
      throw Error(fmt::format("{}: holds more than {} files; expected the folder of one recording", folder.string(),
                              entries > most_entries ? most_entries : most_files));
  }
  if (failure) throw Error(fmt::format("{}: cannot be read: {}", folder.string(), failure.message()));
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) { return in_natural_order(a.string(), b.string()); });
  return files;
}

}  // namespace

bool in_natural_order(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i, ++k;
      continue;
    }
    const auto number = [&](std::string_view text, std::size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const std::size_t begin = at;
      while (at < text.size() && is_digit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string_view first = number(a, i), second = number(b, k);
    if (first.size() != second.size()) return first.size() < second.size();
    if (first != second) return first < second;
  }
  return a.size() - i != b.size() - k ? a.size() - i < b.size() - k : a < b;  // of equal ones some order, always the same
}

bool is_several_files(const fs::path& recording) {
  std::error_code none;
  return fs::is_directory(recording, none) || !joined_parts(recording).empty();
}

std::vector<fs::path> files_of(const fs::path& recording) {
  std::error_code none;
  if (fs::is_directory(recording, none)) return files_below(recording);
  std::vector<fs::path> parts = joined_parts(recording);
  if (parts.empty()) parts.push_back(recording);
  return parts;
}

std::uintmax_t bytes_of(const fs::path& recording) {
  std::uintmax_t all = 0;
  for (const fs::path& file : files_of(recording)) {
    std::error_code unknown;
    const std::uintmax_t bytes = fs::file_size(file, unknown);
    if (!unknown) all += bytes;
  }
  return all;
}

std::string series_of(const fs::path& file) {
  if (!has_extension(file, bag_extensions)) return "";
  const std::string stem = file.stem().string();
  const std::size_t number = stem.find_last_not_of("0123456789") + 1;
  if (number == stem.size() || number < 2 || stem[number - 1] != '_') return "";
  return (file.parent_path() / stem.substr(0, number - 1)).string() + file.extension().string();
}

std::vector<std::string> with_series_joined(const std::vector<std::string>& files) {
  std::vector<std::string> joined;
  std::string series;
  for (const std::string& file : files) {
    const std::string own = series_of(file);
    if (!own.empty() && own == series) {
      joined.back() += "+" + fs::path(file).filename().string();
    } else {
      joined.push_back(file);
    }
    series = own;
  }
  return joined;
}

fs::path without_slash(const fs::path& path) { return path.has_filename() || !path.has_parent_path() ? path : path.parent_path(); }

}  // namespace imulab
