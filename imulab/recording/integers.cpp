#include "imulab/recording/integers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

struct IntegerKind {
  Integers integers;
  std::string_view name;
  int bits;
  bool is_signed;
};

constexpr std::array integer_kinds{
    IntegerKind{Integers::int16, "int16", 16, true}, IntegerKind{Integers::uint16, "uint16", 16, false},
    IntegerKind{Integers::int24, "int24", 24, true}, IntegerKind{Integers::uint24, "uint24", 24, false},
    IntegerKind{Integers::int32, "int32", 32, true}, IntegerKind{Integers::uint32, "uint32", 32, false},
};

constexpr double near_an_end = 0.375;  // of the unsigned range: 1.5 g of an accelerometer whose range is 2 g; the middle is that of offset binary

const IntegerKind* kind_of(Integers integers) {
  const auto* found = std::find_if(integer_kinds.begin(), integer_kinds.end(), [&](const IntegerKind& k) { return k.integers == integers; });
  return found == integer_kinds.end() ? nullptr : found;
}

double taken_as(const IntegerKind& kind, double number) {
  const double range = std::ldexp(1, kind.bits), least = kind.is_signed ? -range / 2 : 0;
  if (number < least && number >= least - range) return number + range;
  if (number >= least + range && number < least + 2 * range) return number - range;
  return number;
}

bool is_whole(const std::vector<double>& column) {
  return !column.empty() && std::all_of(column.begin(), column.end(), [](double v) { return v == std::floor(v); });
}

Integers integers_by_jumps(const std::vector<double>& column) {
  if (!is_whole(column)) return Integers::as_written;
  const auto [low, high] = std::minmax_element(column.begin(), column.end());
  for (const IntegerKind& kind : integer_kinds) {
    const double range = std::ldexp(1, kind.bits), least_printed = kind.is_signed ? 0 : -range / 2;
    if (*low < least_printed || *high >= least_printed + range) continue;
    constexpr double smooth = 0.25;  // of the range
    std::size_t jumps = 0;
    bool is_smooth = true, falls = false;  // a clock or a counter that wraps never falls
    for (std::size_t i = 1; i < column.size(); ++i) {
      const double step = taken_as(kind, column[i]) - taken_as(kind, column[i - 1]);
      jumps += std::abs(column[i] - column[i - 1]) > range / 2;
      is_smooth = is_smooth && std::abs(step) < smooth * range;
      falls = falls || step < 0;
    }
    if (jumps > 0 && is_smooth && falls) return kind.integers;
  }
  return Integers::as_written;
}

/// True if all numbers are from `begin` to `end`, as parts of a range.
bool keeps_within(const std::vector<double>& column, double begin, double end, double range) {
  return std::all_of(column.begin(), column.end(), [&](double v) { return v >= begin * range && v < end * range; });
}

/// The signed kind near the ends of whose unsigned range all columns keep, some of them at its top; clocks and counters, which only grow, do not
/// count.
const IntegerKind* kind_at_the_ends(const std::vector<const std::vector<double>*>& columns) {
  for (const IntegerKind& kind : integer_kinds) {
    if (!kind.is_signed) continue;
    const double range = std::ldexp(1, kind.bits);
    std::size_t at_0 = 0, at_the_top = 0, readings = 0;
    for (const std::vector<double>* column : columns) {
      if (!is_whole(*column) || std::is_sorted(column->begin(), column->end())) continue;
      ++readings;
      at_0 += keeps_within(*column, 0, near_an_end, range);
      at_the_top += keeps_within(*column, 1 - near_an_end, 1, range);
    }
    if (at_the_top > 0 && readings >= 3 && at_0 + at_the_top == readings) return &kind;
  }
  return nullptr;
}

}  // namespace

std::string_view to_string(Integers integers) {
  const IntegerKind* kind = kind_of(integers);
  return kind == nullptr ? "as_written" : kind->name;
}

void take_as(Integers integers, std::vector<double>& column) {
  const IntegerKind* kind = kind_of(integers);
  if (kind == nullptr) return;
  for (double& number : column) number = taken_as(*kind, number);
}

std::vector<Integers> integers_of(const std::vector<const std::vector<double>*>& columns) {
  std::vector<Integers> kinds;
  for (const std::vector<double>* column : columns) kinds.push_back(integers_by_jumps(*column));
  const auto jumping = std::find_if(kinds.begin(), kinds.end(), [](Integers kind) { return kind != Integers::as_written; });
  const IntegerKind* kind = jumping != kinds.end() ? kind_of(*jumping) : kind_at_the_ends(columns);
  if (kind == nullptr) return {};
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == Integers::as_written && kind->is_signed && keeps_within(*columns[i], 1 - near_an_end, 1, std::ldexp(1, kind->bits)) &&
        !std::is_sorted(columns[i]->begin(), columns[i]->end()))
      kinds[i] = kind->integers;
  return kinds;
}

}  // namespace imulab
