#include "imulab/formats/text/several_files.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <system_error>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// What files of a recording are called. All else, above all pictures, is neither read nor summed.
constexpr std::array<std::string_view, 14> read_extensions{".csv", ".tsv",  ".txt", ".dat", ".log", ".json", ".yaml",
                                                           ".yml", ".mcap", ".db3", ".bag", ".xml", ".zstd", ".imu"};
constexpr std::array<std::string_view, 3> bag_extensions{".bag", ".mcap", ".db3"};

template <std::size_t N>
bool has_extension(const fs::path& file, const std::array<std::string_view, N>& known) {
  return std::find(known.begin(), known.end(), lowered(file.extension().string())) != known.end();
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

namespace {

/// True if files of one series, in their order, are all of its parts: recorders number these from 0.
bool are_all_parts(const std::vector<std::string>& files) {
  for (std::size_t k = 0; k < files.size(); ++k)
    if (!fs::path(files[k]).stem().string().ends_with(fmt::format("_{}", k))) return false;
  return files.size() > 1;
}

}  // namespace

std::vector<std::string> with_series_joined(const std::vector<std::string>& files) {
  std::vector<std::string> joined;
  for (std::size_t begin = 0; begin < files.size();) {
    const std::string series = series_of(files[begin]);
    std::size_t end = begin + 1;
    while (!series.empty() && end < files.size() && series_of(files[end]) == series) ++end;
    std::vector<std::string> parts(files.begin() + static_cast<std::ptrdiff_t>(begin), files.begin() + static_cast<std::ptrdiff_t>(end));
    std::sort(parts.begin(), parts.end(), [](const std::string& a, const std::string& b) { return in_natural_order(a, b); });
    if (are_all_parts(parts)) {
      joined.push_back(parts.front());
      for (std::size_t k = 1; k < parts.size(); ++k) joined.back() += "+" + fs::path(parts[k]).filename().string();
    } else {
      joined.insert(joined.end(), files.begin() + static_cast<std::ptrdiff_t>(begin), files.begin() + static_cast<std::ptrdiff_t>(end));
    }
    begin = end;
  }
  return joined;
}

fs::path without_slash(const fs::path& path) { return path.has_filename() || !path.has_parent_path() ? path : path.parent_path(); }

}  // namespace imulab
