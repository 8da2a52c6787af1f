#include "imulab/inspection/holes.hpp"

#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace imulab::inspection {
namespace {

/// Two sensors of which each has its own rows, with blanks in the other's columns.
std::string merged_rows(const SignalTable& table) {
  const Signal* first = nullptr;
  for (const Signal& signal : table.signals) {
    const auto finite =
        static_cast<std::size_t>(std::count_if(signal.values.begin(), signal.values.end(), [](double v) { return std::isfinite(v); }));
    if (finite < 20 || finite + 20 > table.rows()) continue;
    if (first == nullptr) first = &signal;
    std::size_t both = 0;
    for (std::size_t i = 0; i < table.rows(); ++i) both += std::isfinite(first->values[i]) && std::isfinite(signal.values[i]);
    if (both == 0)
      return fmt::format(
          "{} and {} have no row in common, as of sensors whose rows were merged: expected the rows of each in a file of its own, and "
          "both files together",
          first->name, signal.name);
  }
  return {};
}

/// Columns of numbers that some rows have none in: none of them is a reading. `named`: those only whose names are of a sensor's axis.
std::string columns_with_holes(const SignalTable& table, bool named) {
  constexpr double most = 0.5;                                                          // of the rows: else it is no column of numbers
  std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, std::vector<std::string>> holed;  // names by the first row and how many
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const std::vector<double>& values = table.signals[i].values;
    const auto is_hole = [](double v) { return !std::isfinite(v); };
    const auto holes = std::count_if(values.begin(), values.end(), is_hole);
    if (holes == 0 || static_cast<double>(holes) > most * static_cast<double>(values.size())) continue;
    const NameHint hint = hint_in(table, i);
    if (named && (hint.axis < 0 || (hint.role != Role::gyro && hint.role != Role::accel))) continue;
    holed[{std::find_if(values.begin(), values.end(), is_hole) - values.begin() + 1, holes}].push_back(column_name(table, i));
  }
  std::string text;
  for (const auto& [where, names] : holed)
    text += fmt::format("{}{} {} no finite number in {} of {} rows, first in {}", text.empty() ? "" : "; ", fmt::join(names, ", "),
                        names.size() == 1 ? "has" : "have", where.second, table.rows(),
                        table.first_line > 0 ? fmt::format("line {}", table.first_line + static_cast<std::size_t>(where.first) - 1)
                                             : fmt::format("row {}", where.first));
  if (!text.empty()) text += ": no more than 1 row in 100 is left out by itself; remove these rows";
  return text;
}

}  // namespace

std::string words_about_holes(const SignalTable& table) {
  const std::string merged = merged_rows(table), holes = merged.empty() ? columns_with_holes(table, false) : merged;
  return holes.empty() ? "" : "; " + holes;
}

std::string holes_of_sensors(const SignalTable& table) { return merged_rows(table).empty() ? columns_with_holes(table, true) : ""; }

}  // namespace imulab::inspection
