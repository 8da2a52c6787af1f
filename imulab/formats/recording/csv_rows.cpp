#include "imulab/formats/recording/csv_rows.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr int unused = -1, time_field = -2, fraction_field = -3;  // what a field of a row is for; else the column of the result

/// Reads the number at p; nullptr where there is none that is finite.
const char* read_number(const char* p, const char* last, double& value) {
  p += text::without_plus({p, static_cast<std::size_t>(last - p)}).data() - p;
  const auto [end, error] = std::from_chars(p, last, value);
  return error == std::errc() && std::isfinite(value) ? end : nullptr;
}

/// Reads the stamp at p as an integer of 10^-exponent; nullptr where there is none.
const char* read_stamp(const char* p, const char* last, int exponent, std::int64_t& stamp) {
  const text::ScaledInteger number = text::scaled_integer(p, last, exponent);
  if (number.status != text::ScaledInteger::Status::good) return nullptr;
  stamp = number.value;
  return number.end;
}

/// Says what is wrong with a row that could not be read, or whose stamp is too far from the zero.
[[noreturn]] void explain(std::string_view line, std::size_t number, const RowPlan& plan, bool too_far = false) {
  const TableLayout& layout = plan.layout;
  const auto fields = fields_of(line, layout);
  if (fields.size() != layout.columns) {
    const std::string origin = layout.names.empty() ? fmt::format("as in line {}", layout.line) : "as in the header";
    throw Error(fmt::format("{}:{}: {} fields; expected {} {}", layout.file, number, fields.size(), layout.columns, origin));
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (plan.fields[i] == unused) continue;
    const std::string_view field = fields[i];
    const std::string where = fmt::format("{}:{}: {}: ", layout.file, number, excerpt(layout.column_name(i)));
    if (field.empty()) throw Error(where + "is empty; expected a number");
    const char* last = field.data() + field.size();
    if (plan.fields[i] == time_field || plan.fields[i] == fraction_field) {
      const text::ScaledInteger stamp =
          text::scaled_integer(field.data(), last, plan.fields[i] == time_field ? plan.exponent : plan.fraction_exponent);
      if (too_far || (stamp.status == text::ScaledInteger::Status::too_large && stamp.end == last))
        throw Error(fmt::format("{}{} is too far from the clock's zero; expected less than 146 years (is the unit right?)", where, excerpt(field)));
      if (stamp.end != last) throw Error(fmt::format("{}\"{}\" is not a time; expected a decimal number", where, excerpt(field)));
      continue;
    }
    double value = 0;
    const std::string_view digits = text::without_plus(field);
    const auto [end, error] = std::from_chars(digits.data(), last, value);
    if (error == std::errc::result_out_of_range)
      throw Error(fmt::format("{}{} is too large or too small; expected a number that a double can hold", where, excerpt(field)));
    if (error != std::errc() || end != last) throw Error(fmt::format("{}\"{}\" is not a number; expected one", where, excerpt(field)));
    if (!std::isfinite(value)) throw Error(fmt::format("{}{} is not a reading; expected a finite number", where, excerpt(field)));
  }
  throw Error(fmt::format("{}:{}: cannot be read; expected a row of numbers", layout.file, number));
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
      p = read_stamp(p, last, plan.exponent, row.stamp);
    } else if (use == fraction_field) {
      p = read_stamp(p, last, plan.fraction_exponent, row.fraction);
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
void expect_repetition(const Row& before, const Row& row, std::size_t line, const RowPlan& plan) {
  const auto field = static_cast<std::size_t>(std::find(plan.fields.begin(), plan.fields.end(), time_field) - plan.fields.begin());
  const std::string where = fmt::format("{}:{}: {}: ", plan.layout.file, line, plan.layout.column_name(field));
  if (row.time_ns < before.time_ns)
    throw Error(fmt::format("{}time runs backwards: {} s after {} s; expected ascending times", where, text::seconds_text(row.time_ns),
                            text::seconds_text(before.time_ns)));
  if (row.values != before.values)
    throw Error(fmt::format("{}{} s is on two rows with different readings; expected one row for each time", where, text::seconds_text(row.time_ns)));
}

}  // namespace

std::string_view take_lines(std::string_view& text, std::size_t bytes) {
  const std::size_t end = text.size() > bytes ? std::min(text.find('\n', bytes), text.size() - 1) + 1 : text.size();
  const std::string_view lines = text.substr(0, end);
  text.remove_prefix(end);
  return lines;
}

RowReader::RowReader(TableLayout layout, const TimeSource& time, std::optional<double> rate_hz, const std::vector<Column>& columns)
    : clock_(time, rate_hz) {
  plan_.layout = std::move(layout);
  plan_.exponent = clock_.exponent();
  plan_.fraction_exponent = clock_.fraction_exponent();
  plan_.fields.assign(plan_.layout.columns, unused);
  stamped_ = time.column.has_value();
  if (time.column) plan_.fields[plan_.layout.find(*time.column)] = time_field;
  if (time.fraction_column) plan_.fields[plan_.layout.find(*time.fraction_column)] = fraction_field;
  int used = 0;
  for (const Column& column : columns) {
    int& use = plan_.fields[plan_.layout.find(column)];
    if (use <= time_field) throw Error(fmt::format("{}: the time column is also named as a reading; expected different columns", plan_.layout.file));
    if (use == unused) use = used++;
    places_.push_back(static_cast<std::size_t>(use));
  }
  row_.values.resize(static_cast<std::size_t>(used));
  next_.values.resize(static_cast<std::size_t>(used));
  next_line_ = plan_.layout.line;
}

/// Gives the row that was read its time; false where that is too far from the zero.
bool RowReader::stamp() {
  const auto time_ns = stamped_ ? clock_.next(next_.stamp, next_.fraction) : clock_.next();
  next_.time_ns = time_ns.value_or(0);
  return time_ns.has_value();
}

void RowReader::continue_after(const Row& last, std::size_t lines) {
  row_ = last;
  any_ = true;
  next_line_ += lines;
}

bool RowReader::next(std::string_view& text) {
  const auto read = plan_.layout.delimiter == ' ' ? read_row<true> : read_row<false>;
  while (!text.empty()) {
    const char *p = text.data(), *const last = p + text.size(), *end = read(p, last, plan_, next_);
    const bool is_row = end != nullptr;
    if (!is_row) {
      end = std::find(p, last, '\n');
      const char* content = std::find_if_not(p, end, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
      if (content != end && *content != '#') explain({p, static_cast<std::size_t>(end - p)}, next_line_, plan_);
    }
    if (is_row && !stamp()) explain({p, static_cast<std::size_t>(end - p)}, next_line_, plan_, true);
    const bool repeats = is_row && any_ && next_.time_ns <= row_.time_ns;
    if (repeats) expect_repetition(row_, next_, next_line_, plan_);
    repeated_ += repeats;
    text.remove_prefix(static_cast<std::size_t>(end - p) + (end < last));
    line_ = next_line_++;
    if (!is_row || repeats) continue;
    std::swap(row_, next_);
    return any_ = true;
  }
  return false;
}

}  // namespace imulab::recording_io
