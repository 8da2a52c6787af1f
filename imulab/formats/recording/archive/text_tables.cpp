#include "imulab/formats/recording/archive/text_tables.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/archive.hpp"
#include "imulab/formats/recording/archive/zip.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

namespace imulab::recording_io {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t bytes_of_member_head = 1 << 18;  // of a text that has to be unpacked
constexpr std::size_t most_texts = 500;

/// "imu0/data" of "imu0/data.csv".
std::string without_extension(const std::string& name) { return fs::path(name).replace_extension().generic_string(); }

std::string table_name(const std::vector<TextMember>& members, const TextMember& member) {
  const std::string name = without_extension(member.name);
  const bool only = std::count_if(members.begin(), members.end(), [&](const TextMember& m) { return without_extension(m.name) == name; }) == 1;
  return only ? name : member.name;
}

/// Describes a member, where it is a table.
std::optional<TableDescription> describe_text_member(const std::vector<TextMember>& members, const TextMember& member) {
  try {
    const TextTable head = member.open(bytes_of_member_head);
    TableDescription table = text_format().describe({head.path()}).front();
    if (head.bytes() > 0)
      table.rows = static_cast<std::size_t>(static_cast<double>(table.rows) * static_cast<double>(member.bytes) / static_cast<double>(head.bytes()));
    table.name = table_name(members, member);
    table.other_names.push_back(member.name);
    return table;
  } catch (const MemoryError&) {
    throw;
  } catch (const Error&) {
    if (members.size() == 1) throw;
    return std::nullopt;  // a log of words, settings
  }
}

constexpr std::array<std::string_view, 5> text_endings{".csv", ".tsv", ".txt", ".dat", ".log"};

}  // namespace

void expect_few(const std::vector<TextMember>& members, const fs::path& path) {
  if (members.size() > most_texts)
    throw Error(fmt::format("{}: holds {} texts; expected those of one recording: at most {}", path.string(), members.size(), most_texts));
}

TextTable::TextTable(fs::path name, std::string text)
    : path_(std::move(name)), bytes_(text.size()), kept_(std::make_unique<KeptFile>(path_, std::move(text))) {}

std::string text_endings_listed() { return fmt::format("{}", fmt::join(text_endings, ", ")); }

bool is_text_name(const fs::path& file) {
  const std::string extension = lowered(file.extension().string());
  return !file.filename().string().starts_with(".") && std::find(text_endings.begin(), text_endings.end(), extension) != text_endings.end();
}

std::vector<TableDescription> describe_texts(const TableRequest& request, const std::vector<TextMember>& members) {
  std::vector<TableDescription> tables;
  for (const TextMember& member : members)
    if (auto table = describe_text_member(members, member)) tables.push_back(*std::move(table));
  if (tables.empty())
    throw Error(fmt::format("{}: none of its {} texts is a table of numbers; expected samples", request.file.string(), members.size()));
  return tables;
}

const TextMember& find_text(const TableRequest& request, const std::vector<TextMember>& members) {
  const auto named = [&](const std::string& topic) {
    return std::find_if(members.begin(), members.end(), [&](const TextMember& m) { return m.name == topic || table_name(members, m) == topic; });
  };
  if (const auto found = named(request.topic); found != members.end()) return *found;
  return *named(find_table(describe_texts(request, members), request.topic, request.file.string()).name);
}

void read_text(const TableRequest& request, const std::vector<TextMember>& members, const Wanted& wanted, const PieceSink& sink) {
  const TextTable table = find_text(request, members).open(whole_text);
  text_format().read({table.path()}, wanted, sink);
}

namespace {

// ---- a folder

std::vector<TextMember> texts_of_folder(const fs::path& folder) {
  std::vector<TextMember> members;
  for (const fs::path& file : files_of(folder)) {
    std::error_code none;
    if (is_text_name(file))
      members.push_back(
          {file.lexically_relative(folder).generic_string(), fs::file_size(file, none), [file](std::uint64_t) { return TextTable(file); }});
  }
  expect_few(members, folder);
  return members;
}

bool is_folder_of_texts(const fs::path& path) {
  std::error_code none;
  if (!fs::is_directory(path, none)) return false;
  const std::vector<fs::path> files = files_of(path);
  return std::any_of(files.begin(), files.end(), is_text_name);
}

}  // namespace

RecordingFormat text_folder_format() {
  RecordingFormat row = text_tables_row<texts_of_folder>("folder of texts");
  row.recognizes_path = is_folder_of_texts;
  return row;
}

RecordingFormat text_archive_format() {
  RecordingFormat row = text_tables_row<texts_of_archive>("compressed text, or archive of texts");
  row.recognizes = [](std::string_view head) {  // NumPy's archives are zip, too
    const std::string_view name = first_member(head);
    return is_packed(head) && !(head.starts_with("PK\3\4") && (name.empty() || name.ends_with(".npy")));
  };
  return row;
}

}  // namespace imulab::recording_io
