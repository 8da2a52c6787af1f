// Recordings whose tables are texts: the files of a folder or of an archive, the sheet of a workbook. Each table is given to the reader of texts
// as if it were a file of its own.
#pragma once

#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace imulab::recording_io {

/// A text with a path for all that reads files: its own, or one by which it is known as long as this exists.
class TextTable {
 public:
  explicit TextTable(std::filesystem::path file) : path_(std::move(file)) {}
  TextTable(std::filesystem::path name, std::string text);

  const std::filesystem::path& path() const { return path_; }
  /// Of a text that is not a file; 0 of one that is.
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::filesystem::path path_;
  std::uint64_t bytes_ = 0;
  std::unique_ptr<KeptFile> kept_;
};

/// One of the texts.
struct TextMember {
  std::string name;         ///< its path, with the extension
  std::uint64_t bytes = 0;  ///< when it is unpacked
  /// Its text, or the lines of its first bytes.
  std::function<TextTable(std::uint64_t most_bytes)> open;
};

inline constexpr std::uint64_t whole_text = std::numeric_limits<std::uint64_t>::max();

/// True for the name of a file that may be a table of text.
bool is_text_name(const std::filesystem::path& file);
/// The endings of those names: ".csv, .tsv".
std::string text_endings_listed();
/// Throws Error for more texts than a recording has.
void expect_few(const std::vector<TextMember>& members, const std::filesystem::path& path);

std::vector<TableDescription> describe_texts(const TableRequest& request, const std::vector<TextMember>& members);
/// The member that a topic names; without one the only table. Throws Error that lists the tables.
const TextMember& find_text(const TableRequest& request, const std::vector<TextMember>& members);
void read_text(const TableRequest& request, const std::vector<TextMember>& members, const Wanted& wanted, const PieceSink& sink);

/// A row of the table of formats for recordings of which `members` lists the texts.
template <std::vector<TextMember> (*members)(const std::filesystem::path& path)>
RecordingFormat text_tables_row(std::string_view name) {
  return {.name = name,
          .recognizes = [](std::string_view) { return false; },
          .describe = [](const TableRequest& request) { return describe_texts(request, members(request.file)); },
          .read = [](const TableRequest& request, const Wanted& wanted,
                     const PieceSink& sink) { read_text(request, members(request.file), wanted, sink); },
          .in_pieces = true,
          .is_text = true,
          .open_text = [](const TableRequest& request) { return find_text(request, members(request.file)).open(whole_text); }};
}

}  // namespace imulab::recording_io
