#include "imulab/inspection/join.hpp"

#include "imulab/error.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/time.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

namespace imulab::inspection {
namespace {

/// Values at times between others, on straight lines; NaN outside.
std::vector<double> values_at(const std::vector<std::int64_t>& at, const std::vector<std::int64_t>& time_ns, const std::vector<double>& values) {
  std::vector<double> result;
  result.reserve(at.size());
  std::size_t after = 0;
  for (const std::int64_t t : at) {
    while (after < time_ns.size() && time_ns[after] < t) ++after;
    if (after == time_ns.size() || (after == 0 && time_ns[0] != t)) {
      result.push_back(std::numeric_limits<double>::quiet_NaN());
    } else if (time_ns[after] == t) {
      result.push_back(values[after]);
    } else {
      const double part = static_cast<double>(t - time_ns[after - 1]) / static_cast<double>(time_ns[after] - time_ns[after - 1]);
      result.push_back(values[after - 1] + part * (values[after] - values[after - 1]));
    }
  }
  return result;
}

/// The range of stamps that lies inside another table's.
std::pair<std::size_t, std::size_t> covered(const std::vector<std::int64_t>& at, const std::vector<std::int64_t>& other) {
  const auto begin = std::lower_bound(at.begin(), at.end(), other.front()), end = std::upper_bound(at.begin(), at.end(), other.back());
  return {static_cast<std::size_t>(begin - at.begin()), static_cast<std::size_t>(end - at.begin())};
}

bool has_column(const SignalTable& table, const std::string& name) {
  return std::any_of(table.signals.begin(), table.signals.end(), [&](const Signal& signal) { return signal.name == name; });
}

}  // namespace

SignalTable joined(std::vector<SignalTable> tables, const Declarations& declared) {
  SignalTable result = std::move(tables.front());
  if (tables.size() == 1) return result;
  Declarations of_all;  // what a column of another table may be called is not asked here
  for (const char* key : {"time.unit", "time.ticks_per_s", "time.wrap_bits"})
    if (const auto found = declared.find(key); found != declared.end()) of_all.insert(*found);
  const TimeGuess reference = declared_time(result, declared, recognize_time(result));
  const std::vector<std::int64_t> time_ns = stamps_of(result, reference);
  const bool by_row = !reference.column && !reference.replaced && declared.contains("rate_hz");
  const auto expect_stamps = [&](const SignalTable& table, const TimeGuess& time) {
    if (!time.column)
      throw Error(table.file +
                  ": has no stamps; expected them, since several tables are joined by time; tables of as many rows are joined row by row where their "
                  "rate is declared: --rate HZ");
  };
  if (!by_row) expect_stamps(result, reference);
  if (!reference.open.empty() && time_ns.empty()) throw Unsupported(fmt::format("{}: {}", result.file, reference.open.line()));
  if (time_ns.empty()) throw Error(result.file + ": has no stamp in some row; expected one in each, since several tables are joined by time");
  std::size_t begin = 0, end = time_ns.size();
  for (std::size_t t = 1; t < tables.size(); ++t) {
    SignalTable& table = tables[t];
    Declarations of_table = of_all;
    if (const auto column = declared.find("time.column"); column != declared.end() && (by_row || has_column(table, column->second)))
      of_table.insert(*column);
    const TimeGuess time = by_row ? reference : declared_time(table, of_table, recognize_time(table));
    if (by_row && table.rows() != time_ns.size())
      throw Error(fmt::format("{}: has {} rows, {} has {}; expected as many, since they are joined row by row, or stamps", table.file, table.rows(),
                              result.file, time_ns.size()));
    if (!by_row) expect_stamps(table, time);
    const std::vector<std::int64_t> own = by_row ? time_ns : stamps_of(table, time);
    if (own.empty() || own.back() < time_ns.front() || own.front() > time_ns.back())
      throw Error(fmt::format("{}: has no time in common with {}; expected recordings by one clock", table.file, result.file));
    const auto [from, to] = covered(time_ns, own);
    begin = std::max(begin, from), end = std::min(end, to);
    result.parts.push_back(
        {table.file == result.file ? "" : std::filesystem::path(table.file).filename().string(), table.topic, time.source, time.open});
    for (std::size_t i = 0; i < table.signals.size(); ++i) {
      if ((time.column && i == *time.column) || (time.fraction && i == *time.fraction)) continue;
      Signal signal = std::move(table.signals[i]);
      signal.values = values_at(time_ns, own, signal.values);
      signal.table = t;
      result.signals.push_back(std::move(signal));
    }
    result.format += "; " + table.format;
    result.notes.insert(result.notes.end(), table.notes.begin(), table.notes.end());
  }
  if (result.first_line > 0) result.first_line += begin;
  for (Signal& signal : result.signals)
    signal.values = {signal.values.begin() + static_cast<std::ptrdiff_t>(begin), signal.values.begin() + static_cast<std::ptrdiff_t>(end)};
  return result;
}

}  // namespace imulab::inspection
