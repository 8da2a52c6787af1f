#include "imulab/results/noise_moving.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

constexpr std::array<std::string_view, 7> cause_names{"white", "vibration", "below 1 Hz", "stamps", "rectification", "drift", "motion"};

struct TriadWords {
  const char *prefix, *name;
};
constexpr std::array<TriadWords, 2> moving_triads{{{"gyro.", "gyro"}, {"accel.", "accelerometer"}}};

/// A cause of a triad's axis.
struct Shown {
  const MovingAxis* axis = nullptr;
  const MovingCause* cause = nullptr;
  std::string letter() const { return axis->name.substr(axis->name.rfind('.') + 1); }
  bool determined() const { return cause != nullptr && cause->factor.determined; }
};

/// The axis with the largest factor, or one whose factor is not determined if none is; without a cause if the triad has none.
Shown worst_of(const NoiseAnalysis& analysis, const TriadWords& triad, std::string_view name) {
  Shown worst;
  for (const MovingAxis& axis : analysis.moving->axes) {
    if (!axis.name.starts_with(triad.prefix)) continue;
    for (const MovingCause& cause : axis.causes) {
      if (cause.name != name) continue;
      const bool larger =
          worst.cause == nullptr || (cause.factor.determined && (!worst.determined() || cause.factor.value > worst.cause->factor.value));
      if (larger) worst = {&axis, &cause};
    }
  }
  return worst;
}

MovingCell cell_of(const Shown& shown) {
  if (shown.cause == nullptr) return {};
  const NoiseCoefficient& f = shown.cause->factor;
  if (!f.determined) return {shown.letter(), "-", std::isfinite(f.upper) ? "below " + text::number(f.upper) : "not determined"};
  const std::string high = std::isfinite(f.upper) ? text::number(f.upper) : "any";
  return {shown.letter(), text::number(f.value), text::number(f.lower) + " to " + high, f.value, f.lower, f.upper};
}

/// The total of a triad's worst axis, by its factor.
const MovingAxis* worst_total(const NoiseAnalysis& analysis, const TriadWords& triad, MovingTotal MovingAxis::*total) {
  const MovingAxis* worst = nullptr;
  for (const MovingAxis& axis : analysis.moving->axes)
    if (axis.name.starts_with(triad.prefix) && std::isfinite((axis.*total).factor) &&
        (worst == nullptr || (axis.*total).value > (worst->*total).value))
      worst = &axis;
  return worst;
}

struct TotalRow {
  const char* name;
  MovingTotal MovingAxis::*total;
  std::size_t term;  // among noise_terms()
};
constexpr std::array<TotalRow, 4> totals{
    {{"N of a reading", &MovingAxis::N, 0}, {"N over 1 s", &MovingAxis::slow_N, 0}, {"K", &MovingAxis::K, 2}, {"bias", &MovingAxis::bias, 1}}};

std::string value_of(const MovingAxis& axis, const TotalRow& row) {
  const NoiseUnit& unit = noise_terms()[row.term].unit(axis.unit);
  return fmt::format("{} {}", text::number((axis.*row.total).value / unit.size), unit.name);
}

/// A size in the unit in which people read it.
std::string moving_size(const MovingAxis& axis, const MovingCause& cause) {
  const bool counts = axis.unit == "count", gyro = axis.unit == "rad/s";
  if (cause.name == "vibration" || cause.name == "stamps")
    return fmt::format("{} {} RMS", text::number(cause.size / (gyro ? unit::deg : 1)), counts ? "count" : gyro ? "deg/s" : "m/s^2");
  if (cause.name == "motion") return fmt::format("{} deg RMS after a rotation", text::number(cause.size / unit::deg));
  const NoiseUnit& unit = noise_terms()[cause.parameter == "N" ? 0 : 1].unit(axis.unit);
  return fmt::format("{} {}", text::number(cause.size / unit.size), unit.name);
}

std::string detail_of(const Shown& shown) {
  const MovingCause& cause = *shown.cause;
  std::string out = std::isfinite(cause.size) ? moving_size(*shown.axis, cause) : "";
  const auto add = [&](const std::string& words) { out += (out.empty() ? "" : ", ") + words; };
  if (cause.hz) add(fmt::format("most at {} Hz", text::number(*cause.hz)));
  if (cause.stamps_s) add(fmt::format("stamps {} ms RMS", text::number(1e3 * *cause.stamps_s, 2)));
  if (cause.temperature_change) add(fmt::format("thermometer {:+.2g}", *cause.temperature_change));
  if (!cause.reason.empty()) add(cause.reason);
  return out;
}

std::string triad_text(const NoiseAnalysis& analysis, const TriadWords& triad) {
  std::string causes;
  bool determined = false;
  for (const std::string_view name : cause_names) {
    const Shown worst = worst_of(analysis, triad, name);
    if (!worst.determined()) continue;
    determined = true;
    const NoiseCoefficient& f = worst.cause->factor;
    if (f.lower > 1 || (f.upper < 1)) causes += fmt::format("{}{} {}", causes.empty() ? " " : ", ", name, text::number(f.value, 2));
  }
  if (!determined) return fmt::format("{}: no factor determined", triad.name);
  std::string use;
  for (const TotalRow& row : totals)
    if (const MovingAxis* const axis = worst_total(analysis, triad, row.total);
        axis != nullptr && row.total != &MovingAxis::slow_N && (axis->*row.total).value > 0 && ((axis->*row.total).factor != 1))
      use += fmt::format("{} {} {}", use.empty() ? ": use" : ",", row.total == &MovingAxis::N ? "N" : row.name, value_of(*axis, row));
  return fmt::format("{}{}{}", triad.name, causes.empty() ? " as at rest" : causes, causes.empty() ? "" : use);
}

}  // namespace

std::vector<MovingRow> moving_rows(const NoiseAnalysis& analysis) {
  std::vector<MovingRow> out;
  for (const std::string_view name : cause_names) {
    const Shown gyro = worst_of(analysis, moving_triads[0], name), accel = worst_of(analysis, moving_triads[1], name);
    if (gyro.cause == nullptr && accel.cause == nullptr) continue;
    out.push_back({std::string(name), (gyro.cause != nullptr ? gyro : accel).cause->parameter, cell_of(gyro), cell_of(accel)});
  }
  return out;
}

std::vector<std::array<std::string, 3>> moving_totals(const NoiseAnalysis& analysis) {
  std::vector<std::array<std::string, 3>> out;
  for (const TotalRow& row : totals) {
    std::array<std::string, 3> cells{row.name, "-", "-"};
    for (std::size_t i = 0; i < 2; ++i)
      if (const MovingAxis* const axis = worst_total(analysis, moving_triads[i], row.total))
        cells[1 + i] = fmt::format("{}, x {}", value_of(*axis, row), text::number((axis->*row.total).factor));
    out.push_back(std::move(cells));
  }
  return out;
}

std::vector<std::string> moving_details(const NoiseAnalysis& analysis) {
  std::vector<std::string> out;
  for (const std::string_view name : cause_names) {
    std::string line;
    std::string first;
    for (const TriadWords& triad : moving_triads) {
      const Shown worst = worst_of(analysis, triad, name);
      if (worst.cause == nullptr) continue;
      const std::string detail = detail_of(worst);
      if (detail.empty() || detail == first) continue;  // one reason of both moving_triads
      first = detail;
      line += fmt::format("{}{} {}: {}", line.empty() ? "" : "; ", triad.name, worst.letter(), detail);
    }
    if (!line.empty()) out.push_back(fmt::format("{}: {}", name, line));
  }
  return out;
}

std::string moving_headline(const NoiseAnalysis& analysis) {
  std::string out;
  for (const TriadWords& triad : moving_triads)
    if (std::ranges::any_of(analysis.moving->axes, [&](const MovingAxis& axis) { return axis.name.starts_with(triad.prefix); }))
      out += (out.empty() ? "" : "; ") + triad_text(analysis, triad);
  return out;
}

std::string moving_text(const NoiseAnalysis& analysis) {
  std::string out = "factors of the noise at rest, of each triad's worst axis\n";
  for (const std::string& file : analysis.moving->files) out += text::wrapped("  ", one_line(file));
  constexpr const char* row = "  {:<14} {:>7} {:<1}  {:<16} {:>7} {:<1}  {:<16} {}\n";
  out += "\n" + fmt::format(row, "cause", "gyro", "", "95 % interval", "accel", "", "95 % interval", "of");
  for (const auto& [cause, parameter, gyro, accel] : moving_rows(analysis))
    out += fmt::format(row, cause, gyro.factor, gyro.axis, gyro.interval, accel.factor, accel.axis, accel.interval, parameter);
  out += "\n";
  for (const auto& [name, gyro, accel] : moving_totals(analysis)) out += fmt::format("  use {:<14} {:<29} {}\n", name, gyro, accel);
  out += "\n";
  for (const std::string& detail : moving_details(analysis)) out += text::wrapped("  ", one_line(detail));
  return out;
}

}  // namespace imulab
