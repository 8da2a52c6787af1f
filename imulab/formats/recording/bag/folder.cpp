#include "imulab/formats/recording/bag/folder.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/formats/text/take_until.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <system_error>

namespace imulab::bag {
namespace {

namespace fs = std::filesystem;

bool is_bag_file(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".bag" || extension == ".mcap" || extension == ".db3";
}

/// A part that was compressed as a whole, as rosbag2 does with --compression-mode file.
bool is_packed_part(const fs::path& file) { return file.extension() == ".zstd" && is_bag_file(file.stem()); }

/// The files of a bag that stand in a folder itself, in the order of their numbers.
std::vector<fs::path> parts_in(const fs::path& folder) {
  constexpr std::size_t most_entries = 100'000;
  std::vector<fs::path> parts;
  std::size_t entries = 0;
  std::error_code failure;
  for (fs::directory_iterator at(folder, failure), end; !failure && at != end && entries < most_entries; at.increment(failure), ++entries)
    if (is_bag_file(at->path()) || is_packed_part(at->path())) parts.push_back(at->path());
  std::sort(parts.begin(), parts.end(), [](const fs::path& a, const fs::path& b) { return in_natural_order(a.string(), b.string()); });
  return parts;
}

std::vector<fs::path> parts_of(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(path, none) ? parts_in(path) : files_of(path);
}

std::string names_of(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back((file.parent_path().filename() / file.filename()).string());
  return text::listed_excerpts(names);
}

/// Leaves the files that metadata.yaml lists, and reports those that are not there or not listed. Without it the files have to be parts of one bag.
void keep_listed(const fs::path& folder, std::vector<fs::path>& parts, std::vector<std::string>& warnings) {
  constexpr std::uint64_t most_metadata = 1 << 20;
  std::error_code none;
  if (!fs::is_directory(folder, none)) return;
  Buffer buffer;
  const fs::path metadata = folder / "metadata.yaml";
  const std::vector<std::string> listed =
      fs::is_regular_file(metadata, none) ? listed_parts(ByteFile(metadata).read_some(0, most_metadata, buffer)) : std::vector<std::string>{};
  if (listed.empty()) {
    const bool series = std::all_of(parts.begin(), parts.end(), [&](const fs::path& p) { return series_of(p) == series_of(parts.front()); });
    if (parts.size() > 1 && (!series || series_of(parts.front()).empty()))
      throw Error(fmt::format("{}: holds several bags; expected one of its files: {}", folder.string(), names_of(parts)));
    return;
  }
  const auto is_listed = [&](const fs::path& p) { return std::find(listed.begin(), listed.end(), p.filename().string()) != listed.end(); };
  for (const std::string& name : listed)
    if (std::none_of(parts.begin(), parts.end(), [&](const fs::path& p) { return p.filename() == name; }))
      warnings.push_back(fmt::format("{}: metadata.yaml lists {}, which is not there: its messages are missing", folder.string(), excerpt(name)));
  for (const fs::path& part : parts)
    if (!is_listed(part))
      warnings.push_back(fmt::format("{}: {} is not listed in metadata.yaml and was left out", folder.string(), part.filename().string()));
  std::erase_if(parts, [&](const fs::path& p) { return !is_listed(p); });
}

void expect_plain(const std::vector<fs::path>& parts) {
  for (const fs::path& part : parts)
    if (is_packed_part(part))
      throw Error(fmt::format("{}: is compressed as a whole; expected it unpacked: zstd -d {}", part.string(), part.string()));
}

void add_topics(std::vector<Topic>& all, const std::vector<Topic>& more, const std::string& file) {
  try {
    for (const Topic& topic : more) {
      add_channel(all, 0, topic.name, topic.type, topic.encoding);
      std::find_if(all.begin(), all.end(), [&](const Topic& t) { return t.name == topic.name; })->messages += topic.messages;
    }
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {} in its files; expected parts of one bag", file, e.what()));
  }
}

}  // namespace

std::vector<std::string> listed_parts(std::string_view metadata) {
  constexpr std::size_t most_parts = 10'000;
  std::vector<std::string> names;
  bool inside = false;
  while (!metadata.empty() && names.size() < most_parts) {
    const std::string_view line = trimmed(text::take_until(metadata, '\n'));
    if (line == "relative_file_paths:") {
      inside = true;
    } else if (inside && line.starts_with("- ")) {
      std::string_view name = line.substr(2);
      if (name.size() > 1 && (name.front() == '"' || name.front() == '\'')) name = name.substr(1, name.size() - 2);
      names.push_back(fs::path(name).filename().string());  // older ones name the folder, too
    } else if (inside) {
      break;
    }
  }
  return names;
}

bool is_split_bag(const fs::path& path) {
  if (!is_several_files(path)) return false;
  const std::vector<fs::path> parts = parts_of(path);
  return !parts.empty() && std::all_of(parts.begin(), parts.end(), [](const fs::path& p) { return is_bag_file(p) || is_packed_part(p); });
}

fs::path only_part(const fs::path& path) {
  if (!is_split_bag(path)) return path;
  std::vector<std::string> ignored;
  std::vector<fs::path> parts = parts_of(path);
  keep_listed(path, parts, ignored);
  return parts.size() == 1 ? parts.front() : path;
}

SplitBag::SplitBag(const fs::path& path) : parts_(parts_of(path)) {
  keep_listed(path, parts_, missing_);
  if (parts_.empty()) throw Error(fmt::format("{}: the folder of a ROS 2 bag without its files; expected .mcap or .db3 files in it", path.string()));
  expect_plain(parts_);
  for (const fs::path& part : parts_) add_topics(topics_, open_bag(part)->topics(), path.string());
}

void SplitBag::each_message(const Topic& topic, const MessageSink& sink) {
  warnings_ = missing_;
  for (const fs::path& part : parts_) {
    const std::unique_ptr<Bag> bag = open_bag(part);
    const std::vector<Topic>& own = bag->topics();
    const auto same = std::find_if(own.begin(), own.end(), [&](const Topic& t) { return t.name == topic.name; });
    if (same == own.end()) continue;
    bag->each_message(*same, sink);
    warnings_.insert(warnings_.end(), bag->warnings().begin(), bag->warnings().end());
  }
}

void SplitBag::count_messages() {
  for (Topic& topic : topics_) topic.messages = 0;
  for (const fs::path& part : parts_) {
    const std::unique_ptr<Bag> bag = open_bag(part);
    bag->count_messages();
    add_topics(topics_, bag->topics(), part.string());
  }
}

namespace {

void refuse_to_rewrite(const fs::path& in, const Topic&, const MessageChange&, WholeFile&) {
  throw Error(in.string() + ": is a bag of several files; expected one, or a .csv file for the compensated recording");
}

}  // namespace

}  // namespace imulab::bag

imulab::RecordingFormat imulab::recording_io::split_bag_format() {
  static constexpr bag::BagFormat format{"/", bag::opened<bag::SplitBag>, bag::refuse_to_rewrite};
  RecordingFormat row = bag::bag_row(
      "bag of several files", [](std::string_view) { return false; }, format);
  row.recognizes_path = bag::is_split_bag;
  return row;
}
