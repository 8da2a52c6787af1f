#include "imulab/inspection/pieces.hpp"

#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/inspection/time.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace imulab::inspection {
namespace {

/// Its column of time.
std::optional<std::size_t> clock_column(const SignalTable& table, const Declarations& declared) {
  return table.rows() > 0 ? declared_time(table, declared, recognize_time(table)).column : std::nullopt;
}

bool names_triad(const SignalTable& table, Role role) {
  const auto of_role = std::count_if(table.signals.begin(), table.signals.end(), [&](const Signal& s) { return hint_of(s.name).role == role; });
  return of_role >= 3;
}

bool have_equal_names(const SignalTable& a, const SignalTable& b) {
  return std::equal(a.signals.begin(), a.signals.end(), b.signals.begin(), b.signals.end(),
                    [](const Signal& x, const Signal& y) { return x.name == y.name && x.column == y.column && x.unit == y.unit; });
}

}  // namespace

bool are_pieces(const std::vector<SignalTable>& given, const Declarations& declared) {
  if (given.size() < 2) return false;
  for (std::size_t k = 0; k < given.size(); ++k)
    for (std::size_t i = 0; i < k; ++i)
      if (given[i].file == given[k].file || !have_equal_names(given[i], given[k])) return false;
  if (names_triad(given.front(), Role::gyro) && names_triad(given.front(), Role::accel)) return true;
  std::vector<std::pair<double, double>> spans;
  for (const SignalTable& table : given) {
    const auto column = clock_column(table, declared);
    if (!column) return false;
    spans.emplace_back(table.signals[*column].values.front(), table.signals[*column].values.back());
  }
  std::sort(spans.begin(), spans.end());
  return std::adjacent_find(spans.begin(), spans.end(), [](const auto& a, const auto& b) { return b.first <= a.second; }) == spans.end();
}

SignalTable appended(std::vector<SignalTable> tables, const Declarations& declared) {
  const std::optional<std::size_t> clock = clock_column(tables.front(), declared);  // they have the same columns
  if (clock)
    std::stable_sort(tables.begin(), tables.end(),
                     [&](const SignalTable& a, const SignalTable& b) { return a.signals[*clock].values.front() < b.signals[*clock].values.front(); });
  SignalTable all = std::move(tables.front());
  for (std::size_t k = 1; k < tables.size(); ++k) {
    SignalTable& table = tables[k];
    if (clock) {
      constexpr double intervals_between = 100;  // a gap that is seen as one
      const double last = all.signals[*clock].values.back();
      std::vector<double>& own = table.signals[*clock].values;
      const double interval = (own.back() - own.front()) / static_cast<double>(own.size());
      if (const double shift = last - own.front() + intervals_between * interval; own.front() <= last)
        for (double& t : own) t += shift;
    }
    for (std::size_t i = 0; i < all.signals.size(); ++i)
      all.signals[i].values.insert(all.signals[i].values.end(), table.signals[i].values.begin(), table.signals[i].values.end());
    all.notes.insert(all.notes.end(), table.notes.begin(), table.notes.end());
  }
  return all;
}

}  // namespace imulab::inspection
