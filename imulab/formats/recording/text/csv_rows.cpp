#include "imulab/formats/recording/text/csv_rows.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
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

/// What is wrong with the field of a stamp; empty where nothing is.
std::string cause_in_stamp(std::string_view field, int exponent, bool too_far) {
  using Status = text::ScaledInteger::Status;
  const char* last = field.data() + field.size();
  const text::ScaledInteger stamp = text::scaled_integer(field.data(), last, exponent);
  if (too_far || (stamp.status == Status::too_large && stamp.end == last))
    return fmt::format("{} is too far from the clock's zero; expected less than 146 years (is the unit right?)", excerpt(field));
  return stamp.end != last ? fmt::format("\"{}\" is not a time; expected a decimal number", excerpt(field)) : "";
}

/// The same of a reading.
std::string cause_in_number(std::string_view field) {
  double value = 0;
  const std::string_view digits = text::without_plus(field);
  const char* last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  if (error == std::errc::result_out_of_range)
    return fmt::format("{} is too large or too small; expected a number that a double can hold", excerpt(field));
  if (error != std::errc() || end != last) return fmt::format("\"{}\" is not a number; expected one", excerpt(field));
  return std::isfinite(value) ? "" : fmt::format("{} is not a reading; expected a finite number", excerpt(field));
}

/// What is wrong with a row that could not be read, or whose stamp is too far from the zero.
std::string cause_in_row(std::string_view line, const RowPlan& plan, bool too_far) {
  const TableLayout& layout = plan.layout;
  const auto fields = fields_of(line, layout);
  if (fields.size() != layout.columns)
    return fmt::format(
        "{} fields; expected {} {}", fields.size(), layout.columns,
        layout.names.empty() ? fmt::format("as in {} {}", layout.counts_elements ? "element" : "line", layout.line) : "as in the header");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const int use = plan.fields[i];
    if (use == unused) continue;
    const std::string_view field = fields[i];
    const bool of_time = use == time_field || use == fraction_field;
    const std::string cause =
        field.empty() ? "is empty; expected a number"
        : layout.rewritten && field.size() > 1 && field.front() == '"'
            ? fmt::format("{} is not written as the other numbers of the file; expected one decimal mark and thousands of three digits",
                          excerpt(field))
        : of_time ? cause_in_stamp(field, use == time_field ? plan.exponent : plan.fraction_exponent, too_far)
                  : cause_in_number(field);
    if (!cause.empty()) return fmt::format("{}: {}", excerpt(layout.column_name(i)), cause);
  }
  return "cannot be read; expected a row of numbers";
}

[[noreturn]] void explain(std::string_view line, std::size_t number, const RowPlan& plan, bool too_far = false) {
  throw Error(fmt::format("{}: {}", plan.layout.at(number), cause_in_row(line, plan, too_far)));
}

/// What loggers and spreadsheets write where a number is missing.
bool is_missing(std::string_view field) {
  static constexpr std::array<std::string_view, 12> words{"", "nan", "NaN", "NAN", "-nan", "null", "NULL", "None", "N/A", "NA", "#N/A", "-"};
  return std::find(words.begin(), words.end(), field) != words.end();
}

/// All fields that are used are numbers or missing ones, and some is missing.
bool misses_numbers(std::string_view line, const RowPlan& plan) {
  const auto fields = fields_of(line, plan.layout);
  if (fields.size() != plan.layout.columns) return false;
  bool missing = false;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (plan.fields[i] == unused) continue;
    const bool of_time = plan.fields[i] == time_field || plan.fields[i] == fraction_field;
    const bool misses = is_missing(fields[i]);
    missing = missing || misses;
    if (!misses && !(of_time ? cause_in_stamp(fields[i], plan.exponent, false) : cause_in_number(fields[i])).empty()) return false;
  }
  return missing;
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
  const std::string where = fmt::format("{}: {}: ", plan.layout.at(line), plan.layout.column_name(field));
  if (row.time_ns < before.time_ns)
    throw Error(fmt::format("{}time runs backwards: {} s after {} s; expected ascending times", where, text::seconds_text(row.time_ns),
                            text::seconds_text(before.time_ns)));
  if (row.values != before.values)
    throw Error(fmt::format("{}{} s is on two rows with different readings; expected one row for each time; {}", where,
                            text::seconds_text(row.time_ns), even_rows_advice()));
}

}  // namespace

std::string_view take_lines(std::string_view& text, std::size_t bytes) {
  const std::size_t end = text.size() > bytes ? std::min(text.find('\n', bytes), text.size() - 1) + 1 : text.size();
  const std::string_view lines = text.substr(0, end);
  text.remove_prefix(end);
  return lines;
}

void LeftOutRows::Kind::add(std::size_t at, std::string why) {
  if (count++ == 0) line = at, cause = std::move(why);
}

void LeftOutRows::append(const LeftOutRows& next, std::size_t line) {
  const auto join = [&](Kind& kind, const Kind& other) {
    if (kind.count == 0) kind.line = line + other.line, kind.cause = other.cause;
    kind.count += other.count;
  };
  join(headers, next.headers), join(empty, next.empty), join(not_finite, next.not_finite), join(tail, next.tail);
}

std::vector<std::string> LeftOutRows::warnings(const TableLayout& layout, std::size_t rows) const {
  std::vector<std::string> warnings;
  const auto add = [&](const Kind& kind, std::string_view consequence) {
    if (kind.count == 0) return;
    warnings.push_back(fmt::format("{}: {} line{} left out{}, the first {} {}: {}", layout.file, kind.count, kind.count == 1 ? "" : "s", consequence,
                                   layout.counts_elements ? "element" : "line", layout.line + kind.line, kind.cause));
  };
  if (not_finite.count * 100 > rows)
    throw Error(fmt::format("{}: {}{}", layout.at(layout.line + not_finite.line), not_finite.cause,
                            not_finite.count > 1 ? fmt::format("; so in {} rows, more than one in a hundred", not_finite.count) : ""));
  add(headers, ""), add(empty, ""), add(not_finite, " (nothing is measured there)"), add(tail, " at the end");
  return warnings;
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

/// Counts a line that is no row, and throws where it must be one.
void RowReader::leave_out(std::string_view line) {
  const std::vector<std::string>& header = plan_.layout.header;
  const std::string_view content = trimmed(line);
  const std::size_t at = next_line_ - plan_.layout.line;
  if (leaves_ == Leaves::none) explain(line, next_line_, plan_);
  if (std::find(header.begin(), header.end(), content) != header.end()) return left_out_.headers.add(at, "the header again");
  const char delimiter = plan_.layout.delimiter;
  if (content.find_first_not_of(std::string{delimiter, ' ', '"', '\t'}) == std::string_view::npos) return left_out_.empty.add(at, "has no values");
  if (!misses_numbers(line, plan_)) explain(line, next_line_, plan_);
  left_out_.not_finite.add(at, cause_in_row(line, plan_, false));
  if (leaves_ == Leaves::few && left_out_.not_finite.count > 1 + rows_ / 100) explain(line, next_line_, plan_);
}

bool RowReader::reads(std::string_view line) {
  const auto read = plan_.layout.delimiter == ' ' ? read_row<true> : read_row<false>;
  return read(line.data(), line.data() + line.size(), plan_, next_) != nullptr;
}

bool RowReader::next(std::string_view& text) {
  const auto read = plan_.layout.delimiter == ' ' ? read_row<true> : read_row<false>;
  while (!text.empty()) {
    const char *p = text.data(), *const last = p + text.size(), *end = read(p, last, plan_, next_);
    const bool is_row = end != nullptr;
    if (!is_row) {
      end = std::find(p, last, '\n');
      const char* content = std::find_if_not(p, end, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
      if (content != end && *content != '#') leave_out({p, static_cast<std::size_t>(end - p)});
    }
    if (is_row && !stamp()) explain({p, static_cast<std::size_t>(end - p)}, next_line_, plan_, true);
    const bool repeats = is_row && any_ && next_.time_ns <= row_.time_ns;
    if (repeats) expect_repetition(row_, next_, next_line_, plan_);
    repeated_ += repeats;
    text.remove_prefix(static_cast<std::size_t>(end - p) + (end < last));
    line_ = next_line_++;
    if (!is_row || repeats) continue;
    std::swap(row_, next_);
    ++rows_;
    return any_ = true;
  }
  return false;
}

}  // namespace imulab::recording_io
