// Fields of a line, and the words for dialects.
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/text/dialect.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

namespace imulab::recording_io {
using text::DateOrder;

std::vector<FieldText> split_fields(std::string_view line, char delimiter) {
  std::vector<FieldText> fields;
  while (true) {
    const std::size_t first = line.find_first_not_of(delimiter == '\t' ? " \r" : " \t\r");
    line.remove_prefix(std::min(first, line.size()));
    if (delimiter == ' ' && line.empty() && !fields.empty()) return fields;
    FieldText field;
    if (line.starts_with('"')) {
      std::size_t end = line.find('"', 1);
      while (end != std::string_view::npos && line.substr(end + 1).starts_with('"')) end = line.find('"', end + 2);
      if (end != std::string_view::npos) {
        field = {trimmed(line.substr(1, end - 1)), true};
        line.remove_prefix(end + 1);
      }
    }
    const std::size_t end = std::min(delimiter == ' ' ? line.find_first_of(" \t\r") : line.find(delimiter), line.size());
    if (!field.quoted) field.text = trimmed(line.substr(0, end));
    fields.push_back(field);
    if (end == line.size()) return fields;
    line.remove_prefix(end + 1);
  }
}

std::string Dialect::words() const {
  std::string words;
  const auto add = [&](bool is, std::string_view word) {
    if (is) words.append(words.empty() ? "" : ", ").append(word);
  };
  const auto uses_any = [&](auto... wanted) { return std::any_of(uses.begin(), uses.end(), [&](FieldUse u) { return ((u == wanted) || ...); }); };
  add(decimal == ',', "decimal commas"), add(thousands != 0, "thousands separated"), add(quotes, "quoted fields");
  add(uses_any(FieldUse::date, FieldUse::date_before, FieldUse::joined_date), "dates");
  add(uses_any(FieldUse::time_of_day), "times of day");
  return words;
}

bool is_text_layout(std::string_view layout) { return layout == "text" || layout.starts_with("text "); }

DeclaredDialect declared_dialect(std::string_view layout, const std::string& file) {
  DeclaredDialect declared;
  if (!is_text_layout(layout)) return declared;
  for (const FieldText& word : split_fields(layout.substr(4), ' ')) {
    if (word.text == "decimal=," || word.text == "decimal=.") {
      declared.decimal = word.text.back();
    } else if (word.text == "dates=dmy" || word.text == "dates=mdy") {
      declared.order = word.text == "dates=dmy" ? DateOrder::day_first : DateOrder::month_first;
    } else if (!word.text.empty()) {
      throw Error(fmt::format("{}: layout = {}: {} is not known; expected decimal=, or decimal=. and dates=dmy or dates=mdy", file, layout,
                              excerpt(word.text)));
    }
  }
  return declared;
}

}  // namespace imulab::recording_io
