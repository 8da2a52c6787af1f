#include "imulab/inspection/even_rows.hpp"

#include "imulab/recording/clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace imulab::inspection {
namespace {

bool readings_differ(const SignalTable& table, const TriadEvidence& triads, std::size_t row) {
  const auto differ = [&](const SignalTriad& triad) {
    return std::any_of(triad.begin(), triad.end(), [&](std::size_t c) { return table.signals[c].values[row] != table.signals[c].values[row - 1]; });
  };
  return (triads.has_gyro && differ(triads.gyro)) || (triads.has_accel && differ(triads.accel));
}

std::size_t repeated_stamps(const SignalTable& table, const TriadEvidence& triads, std::span<const std::int64_t> time_ns) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < time_ns.size(); ++i) count += time_ns[i] == time_ns[i - 1] && readings_differ(table, triads, i);
  return count;
}

/// The largest rate over the least, in the eighths of the rows.
double spread_of_rate(std::span<const std::int64_t> time_ns) {
  constexpr std::size_t parts = 8;
  double least = HUGE_VAL, most = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * (time_ns.size() - 1) / parts, last = (part + 1) * (time_ns.size() - 1) / parts;
    const double interval = static_cast<double>(time_ns[last] - time_ns[first]) / static_cast<double>(last - first);
    least = std::min(least, interval), most = std::max(most, interval);
  }
  return most / least;
}

}  // namespace

void take_even_rows(const SignalTable& table, std::span<const std::int64_t> time_ns, Inspection& result) {
  constexpr double most_spread = 1.03;  // rounding, and the scheduling of a busy computer
  if (!result.triads || time_ns.size() < 64 || !result.source.time.column || result.source.time.unit == "sample") return;
  const std::size_t repeated = repeated_stamps(table, *result.triads, time_ns);
  if (repeated == 0) return;
  const double span_s = 1e-9 * static_cast<double>(time_ns.back() - time_ns.front()), rate_hz = static_cast<double>(time_ns.size() - 1) / span_s;
  if (!(spread_of_rate(time_ns) < most_spread)) {
    result.ask({"time.column",
                fmt::format("{} stamps are on two rows with different readings, and the rate changes; {}", repeated, even_rows_advice(rate_hz))});
    return;
  }
  result.source.time = {};
  result.source.time.column.reset();
  result.source.time.unit = "sample";
  result.source.rate_hz = result.rate_hz = rate_hz;
  result.note(
      fmt::format("{} stamps are on two rows with different readings, as of few digits; the rows are taken at equal spacing, {:.5g} "
                  "Hz, as the stamps give on average",
                  repeated, rate_hz));
}

}  // namespace imulab::inspection
