#include "imulab/io/timed_table.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/decimal.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/table_layout.hpp"
#include "imulab/io/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace imulab {
namespace {

constexpr int unused = -1, time_field = -2;  // what a field of a row is for; else the column of the result

struct RowPlan {
  TableLayout layout;
  std::vector<int> fields;  ///< for each field of a row
  int exponent = 9;
  std::int64_t zero_ns = 0;
};

/// The values of a row, where they were read.
struct Row {
  std::int64_t time_ns = 0;
  std::vector<double> values;
};

/// Reads the number at p; nullptr where there is none that is finite.
const char* read_number(const char* p, const char* last, double& value) {
  if (p < last && *p == '+') ++p;
  const auto [end, error] = std::from_chars(p, last, value);
  return error == std::errc() && std::isfinite(value) ? end : nullptr;
}

/// Reads the stamp at p; nullptr where there is none, or one so far out that differences of stamps would not fit.
const char* read_time(const char* p, const char* last, const RowPlan& plan, std::int64_t& time_ns) {
  constexpr std::int64_t farthest = std::numeric_limits<std::int64_t>::max() / 2;  // 146 years
  const ScaledInteger stamp = scaled_integer(p, last, plan.exponent);
  if (stamp.status != ScaledInteger::Status::good || __builtin_sub_overflow(stamp.value, plan.zero_ns, &time_ns)) return nullptr;
  return time_ns >= -farthest && time_ns <= farthest ? stamp.end : nullptr;
}

/// A field as it is quoted in a message.
std::string shortened(std::string_view field) {
  constexpr std::size_t longest = 40;
  return field.size() <= longest ? std::string(field) : fmt::format("{}... ({} characters)", field.substr(0, longest), field.size());
}

/// Says what is wrong with a row that could not be read.
[[noreturn]] void explain(std::string_view line, std::size_t number, const RowPlan& plan) {
  const TableLayout& layout = plan.layout;
  const auto fields = fields_of(line, layout);
  if (fields.size() != layout.columns) {
    const std::string origin = layout.names.empty() ? fmt::format("as in line {}", layout.line) : "as in the header";
    throw Error(fmt::format("{}:{}: {} fields, expected {} {}", layout.file, number, fields.size(), layout.columns, origin));
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (plan.fields[i] == unused) continue;
    const std::string_view field = fields[i];
    const std::string where = fmt::format("{}:{}: {}: ", layout.file, number, layout.column_name(i));
    if (field.empty()) throw Error(where + "is empty, expected a number");
    const char* last = field.data() + field.size();
    if (plan.fields[i] == time_field) {
      std::int64_t time_ns = 0;
      const ScaledInteger stamp = scaled_integer(field.data(), last, plan.exponent);
      if (stamp.status != ScaledInteger::Status::not_a_number && stamp.end == last && read_time(field.data(), last, plan, time_ns) == nullptr)
        throw Error(fmt::format("{}{} is too far from the clock's zero, expected less than 146 years (is the unit right?)", where, shortened(field)));
      if (stamp.end != last) throw Error(fmt::format("{}\"{}\" is not a time, expected a decimal number", where, shortened(field)));
      continue;
    }
    double value = 0;
    const std::string_view digits = field.substr(field.front() == '+');
    const auto [end, error] = std::from_chars(digits.data(), last, value);
    if (error == std::errc::result_out_of_range) throw Error(fmt::format("{}{} is beyond what a double holds", where, shortened(field)));
    if (error != std::errc() || end != last) throw Error(fmt::format("{}\"{}\" is not a number", where, shortened(field)));
    if (!std::isfinite(value)) throw Error(fmt::format("{}{} is not a reading, expected a finite number", where, shortened(field)));
  }
  throw Error(fmt::format("{}:{}: cannot be read", layout.file, number));
}

/// Reads one row that begins at p into `row`; returns the end of its line, or nullptr where something is wrong with it. With Blanks, runs of
/// blanks divide the fields.
template <bool Blanks>
const char* read_row(const char* p, const char* last, const RowPlan& plan, Row& row) {
  const char delimiter = plan.layout.delimiter;
  const auto is_blank = [delimiter](char c) { return c == ' ' || c == '\r' || (c == '\t' && (Blanks || delimiter != '\t')); };
  const auto skip_blanks = [&] {
    while (p < last && is_blank(*p)) ++p;
  };
  const std::size_t count = plan.fields.size();
  for (std::size_t i = 0; i < count; ++i) {
    skip_blanks();
    const char* begin = p;
    const int use = plan.fields[i];
    if (use >= 0) {
      p = read_number(p, last, row.values[static_cast<std::size_t>(use)]);
    } else if (use == time_field) {
      p = read_time(p, last, plan, row.time_ns);
    } else {
      while (p < last && *p != '\n' && (Blanks ? !is_blank(*p) : *p != delimiter)) ++p;
    }
    if (p == nullptr || (Blanks && p == begin)) return nullptr;
    const char* end = p;
    skip_blanks();
    if (i + 1 == count) break;
    if (p == last || (Blanks ? p == end || *p == '\n' : *p != delimiter)) return nullptr;
    if (!Blanks) ++p;
  }
  return p == last || *p == '\n' ? p : nullptr;
}

/// For a row whose time is not after the one before: throws unless it is that row again.
void expect_repetition(const TimedTable& table, const Row& row, std::size_t line, const RowPlan& plan) {
  const std::int64_t before = table.time_ns.back();
  const auto time_name = [&] {
    return plan.layout.column_name(static_cast<std::size_t>(std::find(plan.fields.begin(), plan.fields.end(), time_field) - plan.fields.begin()));
  };
  if (row.time_ns < before)
    throw Error(fmt::format("{}:{}: {}: time runs backwards, {} s after {} s", table.file, line, time_name(), seconds_text(row.time_ns),
                            seconds_text(before)));
  for (std::size_t k = 0; k < row.values.size(); ++k)
    if (row.values[k] != table.values[k].back())
      throw Error(fmt::format("{}:{}: {}: {} s stands on two rows with different readings, expected one row a time", table.file, line, time_name(),
                              seconds_text(row.time_ns)));
}

void reserve(TimedTable& table, std::string_view rows) {
  const std::string_view head = rows.substr(0, 1 << 16);
  const auto lines = static_cast<std::size_t>(std::count(head.begin(), head.end(), '\n')) + 1;
  const std::size_t estimate = rows.size() / (head.size() / lines + 1) * 21 / 20 + 16;  // pages never touched cost nothing
  table.time_ns.reserve(estimate);
  for (auto& column : table.values) column.reserve(estimate);
}

template <bool Blanks>
void read_rows(TimedTable& table, std::string_view text, const RowPlan& plan) {
  const char* p = text.data() + plan.layout.offset;
  const char* const last = text.data() + text.size();
  Row row;
  row.values.resize(table.values.size());
  for (std::size_t line = plan.layout.line; p < last; ++line, p += p < last) {
    const char* end = read_row<Blanks>(p, last, plan, row);
    if (end == nullptr) {
      end = std::find(p, last, '\n');
      const char* content = std::find_if_not(p, end, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
      if (content != end && *content != '#') explain({p, static_cast<std::size_t>(end - p)}, line, plan);
    } else if (!table.time_ns.empty() && row.time_ns <= table.time_ns.back()) {
      expect_repetition(table, row, line, plan);
      ++table.repeated;
    } else {
      table.lines.add(table.time_ns.size(), line);
      table.time_ns.push_back(row.time_ns);
      for (std::size_t k = 0; k < row.values.size(); ++k) table.values[k].push_back(row.values[k]);
    }
    p = end;
  }
}

}  // namespace

std::size_t LineNumbers::operator[](std::size_t row) const {
  const auto after = std::upper_bound(jumps_.begin(), jumps_.end(), row, [](std::size_t r, const auto& jump) { return r < jump.first; });
  if (after == jumps_.begin()) return 0;
  return row + (std::prev(after)->second - std::prev(after)->first);
}

TimedTable read_timed_table(const std::filesystem::path& path, const TimeSource& time, const std::vector<Column>& columns) {
  const MappedFile file(path);
  const auto is_named = [](const Column& column) { return std::holds_alternative<std::string>(column); };
  RowPlan plan;
  plan.layout = table_layout(path.string(), file.text(), is_named(time.column) || std::any_of(columns.begin(), columns.end(), is_named));
  plan.exponent = time_exponent(time.unit);
  plan.zero_ns = time.zero_ns;
  plan.fields.assign(plan.layout.columns, unused);
  plan.fields[plan.layout.find(time.column)] = time_field;

  TimedTable table;
  table.file = path.string();
  std::vector<std::size_t> slots;  // where each asked column is in the row; a column may be asked twice
  int used = 0;
  for (const Column& column : columns) {
    int& use = plan.fields[plan.layout.find(column)];
    if (use == time_field) throw Error(fmt::format("{}: the time column is also asked for a reading", table.file));
    if (use == unused) use = used++;
    slots.push_back(static_cast<std::size_t>(use));
  }
  table.values.resize(static_cast<std::size_t>(used));
  reserve(table, file.text().substr(plan.layout.offset));
  plan.layout.delimiter == ' ' ? read_rows<true>(table, file.text(), plan) : read_rows<false>(table, file.text(), plan);

  std::vector<std::vector<double>> values(slots.size());
  for (std::size_t i = slots.size(); i-- > 0;) {
    const bool again =
        std::find(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(i), slots[i]) != slots.begin() + static_cast<std::ptrdiff_t>(i);
    values[i] = again ? table.values[slots[i]] : std::move(table.values[slots[i]]);
  }
  table.values = std::move(values);
  return table;
}

}  // namespace imulab
