// The dialect of a text, from its first lines.
#include "imulab/formats/recording/text/dialect.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/text/number_form.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/take_until.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace imulab::recording_io {
namespace {

using text::DateOrder;
using text::Moment;
using text::moment_of;

constexpr std::size_t lines_looked_at = 200, bytes_looked_at = std::size_t{1} << 18;

/// A line with its place.
struct HeadLine {
  std::string_view text;
  std::size_t number = 0;
  std::vector<FieldText> fields{};  ///< between the delimiter that was found
};

/// Calls `each` with the lines that have something in them and are no comments, until it returns false.
template <class Each>
void for_lines(std::string_view lines, Each&& each) {
  for (std::size_t number = 1; !lines.empty(); ++number) {
    const std::string_view line = text::take_until(lines, '\n'), content = trimmed(line);
    if (!content.empty() && content.front() != '#' && !each(line, number)) return;
  }
}

bool is_value(const FieldText& field) { return number_form(field.text).number || moment_of(field.text); }

/// A row: half of the fields that are not empty or more are values.
bool is_row_of_values(const std::vector<FieldText>& fields, bool all) {
  std::size_t values = 0, filled = 0;
  for (const FieldText& field : fields) {
    if (field.text.empty()) continue;
    ++filled;
    values += is_value(field);
  }
  return values >= 1 && (all ? values == filled : 2 * values >= filled);
}

/// How many lines are rows of two values or more between this delimiter.
std::size_t rows_between(const std::vector<HeadLine>& lines, char delimiter, bool all) {
  return static_cast<std::size_t>(std::count_if(lines.begin(), lines.end(), [&](const HeadLine& line) {
    const std::vector<FieldText> fields = split_fields(line.text, delimiter);
    const auto filled = std::count_if(fields.begin(), fields.end(), [](const FieldText& f) { return !f.text.empty(); });
    return filled > 1 && is_row_of_values(fields, all);
  }));
}

/// The delimiter of most lines; 0 where no line is a row. A comma may be a decimal one beside any other delimiter, so that it comes after them; a tab
/// may be a mere blank beside a comma, and then leaves commas at the ends of its fields, which no number has.
char delimiter_between(const std::vector<HeadLine>& lines) {
  struct Candidate {
    char delimiter;
    bool all;  ///< every field has to be a value
  };
  static constexpr std::array<Candidate, 5> candidates{{{'|', false}, {';', false}, {'\t', false}, {' ', true}, {',', false}}};
  const auto with_comma = std::count_if(lines.begin(), lines.end(), [](const HeadLine& l) { return l.text.find(',') != std::string_view::npos; });
  char best = 0;
  std::size_t most = 0;
  for (const auto& [delimiter, all] : candidates) {
    if (delimiter == ' ' && with_comma == 0) continue;  // with nothing else it is left
    const std::size_t rows = rows_between(lines, delimiter, all);
    if (rows > most) most = rows, best = delimiter;
  }
  if (best == 0 && rows_between(lines, ' ', false) > 0) best = ' ';
  return best;
}

/// All that is known while a dialect is being recognized.
struct Head {
  const std::string& file;
  std::string_view text;  ///< the whole
  bool complete = true;
  std::vector<HeadLine> rows{};        ///< the first lines that are rows
  std::size_t before = 0;              ///< fields of the line before them
  std::vector<HeadLine> usual_rows{};  ///< of those the ones with as many fields as most
};

[[noreturn]] void fail_at(const Head& head, std::size_t line, std::size_t column, std::string_view field, const std::string& what) {
  throw Error(fmt::format("{}:{}: column {}: \"{}\" {}", head.file, line, column + 1, excerpt(field), what));
}

/// The places of what the numbers of a text show, each the first one.
struct Shown {
  struct Place {
    std::size_t line = 0, column = 0;
    std::string text{};
  };
  Place decimal_comma, decimal_point, comma_groups, point_groups, comma_unknown, point_unknown;
  char groups = 0;

  void add(const HeadLine& line, char delimiter) {
    for (std::size_t i = 0; i < line.fields.size(); ++i) {
      const FieldText& field = line.fields[i];
      const NumberForm form = number_form(field.text);
      if (!form.number || (form.groups == ' ' && delimiter == ' ')) continue;
      const auto put = [&](bool shown, Place& place) {
        if (shown && place.line == 0) place = {line.number, i, std::string(field.text)};
      };
      put(form.decimal_comma, decimal_comma), put(form.decimal_point, decimal_point);
      put(form.comma_groups, comma_groups), put(form.point_groups, point_groups);
      put(form.comma_unknown, comma_unknown), put(form.point_unknown, point_unknown);
      if (form.groups != 0) groups = form.groups;
    }
  }
  bool comma_settled() const { return decimal_comma.line + comma_groups.line + decimal_point.line + point_groups.line > 0; }
};

/// What the first rows leave open, the others may show.
void look_further(const Head& head, char delimiter, Shown& shown) {
  for_lines(head.text, [&](std::string_view line, std::size_t number) {
    HeadLine row{line, number, split_fields(line, delimiter)};
    if (is_row_of_values(row.fields, false)) shown.add(row, delimiter);
    return !shown.comma_settled();
  });
}

/// Sets the decimal mark and the sign between thousands; false where more text has to come.
bool settle_numbers(const Head& head, const DeclaredDialect& declared, Dialect& dialect) {
  Shown shown;
  for (const HeadLine& row : head.rows) shown.add(row, dialect.delimiter);
  dialect.thousands = shown.groups;
  if (shown.comma_unknown.line > 0 && !shown.comma_settled() && !declared.decimal) look_further(head, dialect.delimiter, shown);
  const bool commas = shown.decimal_comma.line + shown.comma_groups.line + shown.comma_unknown.line > 0;
  if (!commas) {
    if (shown.point_groups.line > 0 && shown.decimal_point.line == 0) dialect.thousands = '.';
    return true;
  }
  const bool comma_decimal = declared.decimal ? *declared.decimal == ',' : shown.decimal_comma.line + shown.point_groups.line > 0;
  if (!comma_decimal && !declared.decimal && !shown.comma_settled()) {
    if (!head.complete) return false;
    const Shown::Place& at = shown.comma_unknown;
    fail_at(head, at.line, at.column, at.text,
            "is one and a fraction or a thousand, and no number of the file shows which; declare it: --set 'layout=text decimal=,' (a fraction) or "
            "'layout=text decimal=.' (a thousand)");
  }
  dialect.decimal = comma_decimal ? ',' : '.';
  const Shown::Place& against = comma_decimal ? (shown.comma_groups.line > 0 ? shown.comma_groups : shown.decimal_point) : shown.decimal_comma;
  if (against.line > 0)
    fail_at(head, against.line, against.column, against.text,
            fmt::format("has another decimal mark than \"{}\" in line {}; expected one convention in a file",
                        comma_decimal ? shown.decimal_comma.text : shown.decimal_point.text,
                        comma_decimal ? shown.decimal_comma.line : shown.decimal_point.line));
  if (comma_decimal && shown.point_groups.line == 0 && shown.point_unknown.line > 0)
    fail_at(head, shown.point_unknown.line, shown.point_unknown.column, shown.point_unknown.text,
            "has a point where other numbers have a decimal comma; expected one convention in a file");
  if (comma_decimal ? shown.point_groups.line > 0 : shown.comma_groups.line + shown.comma_unknown.line > 0)
    dialect.thousands = comma_decimal ? '.' : ',';
  return true;
}

/// Whether nearly all rows have this in a field.
template <class Test>
bool nearly_all(const std::vector<HeadLine>& rows, std::size_t column, Test&& test) {
  const auto count = static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [&](const HeadLine& row) { return column < row.fields.size() && test(row.fields[column].text); }));
  return !rows.empty() && 10 * count >= 9 * rows.size();
}

void use_as(Dialect& dialect, std::size_t column, FieldUse use) {
  if (dialect.uses.size() <= column) dialect.uses.resize(column + 1, FieldUse::number_or_text);
  dialect.uses[column] = use;
}

/// The order of dates like 03/04/2025 in a column: what any of them shows; false where more text has to come.
bool settle_order(const Head& head, std::size_t column, const DeclaredDialect& declared, Dialect& dialect) {
  HeadLine first{{}, 0};
  std::string example;
  for_lines(head.text, [&](std::string_view line, std::size_t number) {
    const std::vector<FieldText> fields = split_fields(line, dialect.delimiter);
    if (column >= fields.size()) return true;
    const Moment moment = moment_of(fields[column].text);
    if (moment.ordered && first.number == 0) first.number = number, example = fields[column].text;
    if (moment.ordered && moment.shows != DateOrder::unknown) dialect.order = moment.shows;
    return dialect.order == DateOrder::unknown && (first.number > 0 || number < lines_looked_at);
  });
  if (dialect.order == DateOrder::unknown) dialect.order = declared.order;
  if (first.number == 0 || dialect.order != DateOrder::unknown) return true;
  if (!head.complete) return false;
  fail_at(head, first.number, column, example,
          "is a day and a month in an order that no date of the file shows; declare it: --set 'layout=text dates=dmy' or 'layout=text dates=mdy'");
}

/// Finds the columns of dates and times of day.
bool settle_dates(const Head& head, const DeclaredDialect& declared, Dialect& dialect) {
  const std::vector<HeadLine>& rows = head.usual_rows;
  const std::size_t columns = rows.empty() ? 0 : rows.front().fields.size();
  const auto has = [&](std::size_t column, bool date, bool time) {
    return column < columns && nearly_all(rows, column, [&](std::string_view field) {
             const Moment moment = moment_of(field);
             return moment.has_date == date && moment.has_time == time;
           });
  };
  for (std::size_t i = 0; i < columns; ++i) {
    if (has(i, true, true)) {
      use_as(dialect, i, FieldUse::date);
    } else if (has(i, true, false) && has(i + 1, false, true)) {
      const bool joined = dialect.delimiter == ' ' && head.before + 1 == columns;
      use_as(dialect, i, joined ? FieldUse::joined_date : FieldUse::date_before);
      use_as(dialect, i + 1, FieldUse::time_after);
    } else if (dialect.use(i) == FieldUse::number_or_text && has(i, false, true)) {
      use_as(dialect, i, FieldUse::time_of_day);
    }
    const FieldUse use = dialect.use(i);
    if ((use == FieldUse::date || use == FieldUse::date_before || use == FieldUse::joined_date) && !settle_order(head, i, declared, dialect))
      return false;
  }
  return true;
}

constexpr std::size_t rows_for_sensors = 8;

/// Some row has a field that is no value.
bool has_text(const Head& head) {
  return std::any_of(head.rows.begin(), head.rows.end(), [](const HeadLine& row) {
    return std::any_of(row.fields.begin(), row.fields.end(), [](const FieldText& f) { return !f.text.empty() && !is_value(f); });
  });
}

bool names_a_sensor(const std::string& name) {
  const inspection::Role role = inspection::hint_of(name).role;
  return role == inspection::Role::accel || role == inspection::Role::gyro;
}

/// Finds the column that names the sensor of each row: few different texts, some of which name an accelerometer or a gyro.
void settle_sensors(const Head& head, Dialect& dialect) {
  constexpr std::size_t most_sensors = 32;
  if (head.rows.size() < rows_for_sensors) return;
  std::size_t columns = head.rows.front().fields.size();
  for (const HeadLine& row : head.rows) columns = std::min(columns, row.fields.size());
  for (std::size_t i = 0; i < columns; ++i) {
    std::map<std::string, std::size_t> names;
    for (const HeadLine& row : head.rows) {
      const std::string name(row.fields[i].text);
      if (name.empty() || is_value(row.fields[i]) || names.size() > most_sensors) break;
      ++names[name];
    }
    std::size_t named = 0, counted = 0, sensors = 0;
    for (const auto& [name, count] : names) named += count, counted += count > 1, sensors += names_a_sensor(name);
    if (named != head.rows.size() || names.size() < 2 || counted < 2 || sensors == 0) continue;
    for (const auto& [name, count] : names) dialect.sensors.push_back(name);
    use_as(dialect, i, FieldUse::sensor);
    return;
  }
}

Head head_of(const std::string& file, std::string_view text, bool complete, Dialect& dialect) {
  Head head{file, text, complete};
  std::vector<HeadLine> lines;
  std::string_view first_text = text.substr(0, bytes_looked_at);
  if (first_text.size() < text.size()) first_text = first_text.substr(0, first_text.rfind('\n') + 1);  // without a line that is cut
  for_lines(first_text, [&](std::string_view line, std::size_t number) {
    lines.push_back({line, number});
    return lines.size() < lines_looked_at;
  });
  dialect.delimiter = delimiter_between(lines);
  if (dialect.delimiter == 0) return head;
  std::map<std::size_t, std::size_t> counts;
  for (HeadLine& line : lines) {
    line.fields = split_fields(line.text, dialect.delimiter);
    if (!is_row_of_values(line.fields, false)) {
      if (head.rows.empty()) head.before = line.fields.size();
      continue;
    }
    ++counts[line.fields.size()];
    head.rows.push_back(std::move(line));
  }
  const auto usual = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const HeadLine& row : head.rows)
    if (row.fields.size() == usual->first) head.usual_rows.push_back(row);
  return head;
}

/// Quotes have to be taken off rows, and off a header in which they hold a delimiter.
bool has_quotes(const Head& head, char delimiter) {
  const auto quoted = [](const HeadLine& row) {
    return std::any_of(row.fields.begin(), row.fields.end(), [](const FieldText& f) { return f.quoted; });
  };
  if (std::any_of(head.rows.begin(), head.rows.end(), quoted)) return true;
  bool needed = false;
  for_lines(head.text.substr(0, bytes_looked_at), [&](std::string_view line, std::size_t number) {
    if (number >= head.rows.front().number) return false;
    for (const FieldText& field : split_fields(line, delimiter))
      needed = needed || (field.quoted && field.text.find(delimiter) != std::string_view::npos);
    return !needed;
  });
  return needed;
}

}  // namespace

std::optional<Dialect> recognize_dialect(const std::string& file, std::string_view text, bool complete, const DeclaredDialect& declared) {
  if (text.starts_with("FMT, 128, 89, FMT,"))
    throw Error(file + ": is ArduPilot's log written as text; expected the log itself (.bin), which has the same readings and is read");
  Dialect dialect;
  const Head head = head_of(file, text, complete, dialect);
  if (head.rows.empty()) return complete ? std::optional(dialect) : std::nullopt;
  dialect.quotes = has_quotes(head, dialect.delimiter);
  settle_sensors(head, dialect);
  if (!complete && head.rows.size() < rows_for_sensors && has_text(head)) return std::nullopt;  // sensors' names, as more rows may show
  if (!settle_dates(head, declared, dialect) || !settle_numbers(head, declared, dialect)) return std::nullopt;
  return dialect;
}

}  // namespace imulab::recording_io
