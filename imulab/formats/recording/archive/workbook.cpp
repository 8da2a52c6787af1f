// Excel workbooks (.xlsx: ECMA-376, part 1, SpreadsheetML): the first sheet as a text divided by tabs, which is read as any other. Only what a table
// of numbers needs is read of the XML: cells with their places, numbers as they are written, texts and shared texts.
#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/text_tables.hpp"
#include "imulab/formats/recording/archive/zip.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

namespace imulab::recording_io {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t most_unpacked = std::uint64_t{1} << 30;
constexpr std::size_t most_columns = 16384, longest_cell = 32767;  // of the format

/// The next tag of an XML text: its name, its attributes, and the text before it.
struct Tag {
  std::string_view before, name, attributes;
  bool closes = false, is_empty = false;
};

/// Takes a tag off the front; nothing where there is none left. Comments and declarations are passed over.
std::optional<Tag> take_tag(std::string_view& xml) {
  while (true) {
    const std::size_t begin = xml.find('<');
    if (begin == std::string_view::npos) return std::nullopt;
    const std::string_view before = xml.substr(0, begin);
    const bool comment = xml.substr(begin, 4) == "<!--";
    const std::size_t end = comment ? xml.find("-->", begin) : xml.find('>', begin);
    if (end == std::string_view::npos) return std::nullopt;
    std::string_view inside = xml.substr(begin + 1, end - begin - 1);
    xml.remove_prefix(end + (comment ? 3 : 1));
    if (comment || inside.starts_with('!') || inside.starts_with('?')) continue;
    Tag tag{before, {}, {}};
    if (inside.starts_with('/')) tag.closes = true, inside.remove_prefix(1);
    if (inside.ends_with('/')) tag.is_empty = true, inside.remove_suffix(1);
    const std::size_t name = std::min(inside.find_first_of(" \t\r\n"), inside.size());
    tag.name = inside.substr(0, name);
    tag.attributes = inside.substr(name);
    if (const std::size_t prefix = tag.name.find(':'); prefix != std::string_view::npos) tag.name.remove_prefix(prefix + 1);
    return tag;
  }
}

/// An attribute's value; empty where it is not there.
std::string_view attribute(std::string_view attributes, std::string_view name) {
  for (std::size_t at = attributes.find(name); at != std::string_view::npos; at = attributes.find(name, at + 1)) {
    const std::size_t quote = at + name.size() + 1;
    if (at == 0 || attributes[at - 1] != ' ' || quote >= attributes.size() || attributes[quote - 1] != '=') continue;
    const std::size_t end = attributes.find(attributes[quote], quote + 1);
    return end == std::string_view::npos ? std::string_view() : attributes.substr(quote + 1, end - quote - 1);
  }
  return {};
}

/// A text of a cell as a field: entities replaced, and nothing in it that divides fields or lines.
std::string field_text(std::string_view text) {
  static constexpr std::array<std::pair<std::string_view, char>, 5> entities{
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}}};
  std::string out;
  for (std::size_t i = 0; i < text.size() && out.size() < longest_cell;) {
    const auto entity = std::find_if(entities.begin(), entities.end(), [&](const auto& e) { return text.substr(i).starts_with(e.first); });
    const char c = entity != entities.end() ? entity->second : text[i];
    out += c == '\t' || c == '\n' || c == '\r' ? ' ' : c;
    i += entity != entities.end() ? entity->first.size() : 1;
  }
  return out;
}

/// The texts to which cells refer by number.
std::vector<std::string> shared_texts(std::string_view xml) {
  std::vector<std::string> texts;
  bool phonetic = false;
  while (const auto tag = take_tag(xml)) {
    if (tag->name == "rPh") phonetic = !tag->closes && !tag->is_empty;
    if (tag->name == "si" && !tag->closes) texts.emplace_back();
    if (tag->name == "t" && tag->closes && !phonetic && !texts.empty() && texts.back().size() < longest_cell) texts.back() += field_text(tag->before);
  }
  return texts;
}

/// "AB12" is in column 27; nothing where it is no place.
std::optional<std::size_t> column_of_place(std::string_view place) {
  std::size_t column = 0;
  for (const char c : place) {
    if (c < 'A' || c > 'Z') break;
    column = 26 * column + static_cast<std::size_t>(c - 'A' + 1);
    if (column > most_columns) return std::nullopt;
  }
  return column > 0 ? std::optional(column - 1) : std::nullopt;
}

/// Rows of a sheet as lines. Cells that are not there are empty fields, up to the last of the row.
class SheetText {
 public:
  SheetText(std::string place, std::vector<std::string> shared) : place_(std::move(place)), shared_(std::move(shared)) {}

  std::string text(std::string_view xml, std::uint64_t most) {
    std::string out;
    const std::uint64_t longest = 16 * xml.size() + (1 << 16);
    while (out.size() < most) {
      const auto tag = take_tag(xml);
      if (!tag) break;
      take(*tag);
      if (tag->name == "row" && tag->closes) {
        if (out.size() + row_.size() > longest)  // far more places than cells
          throw Error(fmt::format("{}: its first sheet is mostly empty; expected a table of numbers", place_));
        out += row_ + "\n";
        row_.clear(), columns_ = next_ = 0;
      }
    }
    return out;
  }

 private:
  void take(const Tag& tag) {
    if (tag.name == "c" && !tag.closes) {
      const std::size_t column = column_of_place(attribute(tag.attributes, "r")).value_or(next_);
      next_ = column + 1;
      while (columns_ < column) row_ += '\t', ++columns_;
      kind_ = attribute(tag.attributes, "t");
    } else if (tag.closes && (tag.name == "v" || (tag.name == "t" && kind_ == "inlineStr"))) {
      if (kind_ == "s") {
        const std::size_t index = static_cast<std::size_t>(std::atoll(std::string(tag.before.substr(0, 12)).c_str()));
        if (index >= shared_.size()) throw Error(fmt::format("{}: a cell refers to a text that is not there; expected a whole workbook", place_));
        row_ += shared_[index];
      } else {
        row_ += field_text(tag.before);
      }
    }
  }

  std::string place_;
  std::vector<std::string> shared_;
  std::string row_;
  std::size_t columns_ = 0, next_ = 0;  // separators in the row; the column after the last cell
  std::string_view kind_;
};

std::string unpacked_part(const std::vector<ZipMember>& members, const std::string& name, const std::string& file) {
  const auto member = std::find_if(members.begin(), members.end(), [&](const ZipMember& m) { return m.name == name; });
  if (member == members.end()) return "";
  const std::string place = file + "/" + name;
  if (member->bytes > most_unpacked) throw Error(fmt::format("{}: is longer than {} MiB; expected a .csv file", place, most_unpacked >> 20));
  return unpacked(*member, place);
}

/// The file of the first sheet, by the workbook and its relations, where they are as Excel and LibreOffice write them.
std::string first_sheet(const std::vector<ZipMember>& members, const std::string& file) {
  const std::string workbook = unpacked_part(members, "xl/workbook.xml", file),
                    relations = unpacked_part(members, "xl/_rels/workbook.xml.rels", file);
  std::string id;
  for (std::string_view xml = workbook; id.empty();) {
    const auto tag = take_tag(xml);
    if (!tag) break;
    if (tag->name == "sheet") id = attribute(tag->attributes, "r:id");
  }
  for (std::string_view xml = relations; !id.empty();) {
    const auto tag = take_tag(xml);
    if (!tag) break;
    if (tag->name != "Relationship" || attribute(tag->attributes, "Id") != id) continue;
    const std::string target(attribute(tag->attributes, "Target"));
    return target.starts_with("/") ? target.substr(1) : "xl/" + target;
  }
  return "xl/worksheets/sheet1.xml";
}

std::string sheet_text(const fs::path& path, std::uint64_t most) {
  const std::string file = path.string();
  const MappedFile archive(path);
  const std::vector<ZipMember> members = zip_members(archive.text(), file);
  const std::string sheet = first_sheet(members, file);
  const std::string xml = unpacked_part(members, sheet, file);
  if (xml.empty()) throw Error(fmt::format("{}: has no sheet {}; expected an Excel workbook with a table in its first sheet", file, sheet));
  return SheetText(file, shared_texts(unpacked_part(members, "xl/sharedStrings.xml", file))).text(xml, most);
}

std::vector<TextMember> texts_of_workbook(const fs::path& path) {
  std::error_code none;
  return {{"first sheet", fs::file_size(path, none) * 5, [path](std::uint64_t most) {
             return TextTable(most == whole_text ? path / "first sheet" : path / "first sheet (its beginning)", sheet_text(path, most));
           }}};
}

}  // namespace

RecordingFormat workbook_format() {
  RecordingFormat row = text_tables_row<texts_of_workbook>("Excel workbook");
  row.recognizes = [](std::string_view head) {
    const std::string_view name = first_member(head);
    return name == "[Content_Types].xml" || name.starts_with("_rels/") || name.starts_with("docProps/") || name.starts_with("xl/");
  };
  return row;
}

}  // namespace imulab::recording_io
