#include "imulab/inspection/inspection.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/evidence.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/inspection/time.hpp"
#include "imulab/model/frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <utility>

namespace imulab {
namespace {

using namespace inspection;

bool whole_numbers(const SignalTable& table, const SignalTriad& triad) {
  return std::all_of(triad.begin(), triad.end(), [&](std::size_t i) {
    const std::vector<double>& values = table.signals[i].values;
    return std::all_of(values.begin(), values.end(), [](double v) { return v == std::floor(v); });
  });
}

std::string name_of(const SignalTable& table, std::size_t i) {
  return table.signals[i].name.empty() ? fmt::format("column {}", i + 1) : table.signals[i].name;
}

std::string names_of(const SignalTable& table, const SignalTriad& triad) {
  return fmt::format("{}, {}, {}", name_of(table, triad[0]), name_of(table, triad[1]), name_of(table, triad[2]));
}

/// The unit that the file or the column's name states for a triad.
std::string stated_unit(const SignalTable& table, const SignalTriad& triad) {
  const Signal& signal = table.signals[triad[0]];
  const NameHint hint = hint_of(signal.name);
  return !signal.unit.empty() ? signal.unit : !hint.unknown.empty() ? hint.unknown : hint.unit;
}

/// The gyros' columns in the order of the accelerometers' axes, where they are merely exchanged; what speaks against them otherwise.
std::string settle_axes(const SignalTable& table, const Declarations& declared, TriadEvidence& triads, Inspection& result) {
  result.source.gyro.axes = declared_axes(declared, "gyro");
  result.source.accel.axes = declared_axes(declared, "accel");
  if (result.source.gyro.axes || result.source.accel.axes) return "axes: as declared";
  if (!triads.explained()) return {};
  const std::string wrong = wrong_axes(*triads.gyro_matrix);
  if (wrong.empty()) return "axes: the gyros turn as gravity does, right-handed";
  SignalTriad ordered = triads.gyro;
  bool reversed = false;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Eigen::Index from = 0;
    triads.gyro_matrix->row(axis).cwiseAbs().maxCoeff(&from);
    ordered[static_cast<std::size_t>(axis)] = triads.gyro[static_cast<std::size_t>(from)];
    reversed = reversed || (*triads.gyro_matrix)(axis, from) < 0;
  }
  if (reversed) {
    result.ambiguous.push_back("gyro.axes: " + wrong +
                               "; the data do not show which sensor is reversed; declare it (accel.axes, or gyro.axes = +x,+y,-z)");
    return {};
  }
  Matrix3d exchange = Matrix3d::Zero();
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (Eigen::Index from = 0; from < 3; ++from)
      exchange(from, axis) = ordered[static_cast<std::size_t>(axis)] == triads.gyro[static_cast<std::size_t>(from)] ? 1 : 0;
  triads.gyro_matrix = *triads.gyro_matrix * exchange;
  triads.gyro = ordered;
  return fmt::format("axes: {}; taken as x, y, z: {}", wrong, names_of(table, ordered));
}

void settle_triad(const SignalTable& table, const SignalTriad& triad, const UnitGuess& guess, const std::string& role, TriadSource& source,
                  Inspection& result) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ColumnFinding& column = result.columns[triad[axis]];
    column.role = role + "." + "xyz"[axis];
    column.unit = guess.unit;
    column.evidence = guess.evidence;
    source.columns.push_back(table.signals[triad[axis]].column);
  }
  source.unit = guess.unit;
  source.output = guess.output;
  if (const std::size_t part = table.signals[triad[0]].table; part > 0) {
    if (!table.parts[part - 1].file.empty()) source.file = table.parts[part - 1].file;
    if (!table.parts[part - 1].topic.empty()) source.topic = table.parts[part - 1].topic;
    if (!(table.parts[part - 1].time == result.source.time)) source.time = table.parts[part - 1].time;
  }
  if (!guess.open.empty()) result.ambiguous.push_back(guess.open);
}

/// Units of both triads.
void settle_units(const SignalTable& table, const TriadEvidence& triads, const TimeGuess& time, const Declarations& declared, Inspection& result) {
  const double interval_s = time.rate_hz ? 1 / *time.rate_hz : 0;
  const bool whole_accel = whole_numbers(table, triads.accel), whole_gyro = whole_numbers(table, triads.gyro);
  UnitGuess accel;
  if (const std::string stated_accel = stated_unit(table, triads.accel); triads.rests.empty()) {
    accel.unit = stated_accel.empty() ? "count" : stated_accel;
    if (stated_accel.empty()) {
      accel.open = "accel.unit: no rest was found, which would show gravity";
    } else {
      accel.evidence = stated_accel + " as the file says; no rest was found that would confirm it";
    }
  } else if (triads.offset_taken_out) {
    accel.evidence = fmt::format("readings at rest lie on a sphere of radius {:.5g} about a point far from zero: counts", triads.norm);
  } else {
    accel = accel_unit(triads.norm, triads.norm_least, triads.norm_most, interval_s, stated_accel, whole_accel);
  }
  declare_unit(declared, "accel", accel);
  UnitGuess gyro;
  const std::string stated = stated_unit(table, triads.gyro);
  if (!triads.explained() || !time.rate_hz) {
    gyro.unit = stated.empty() ? "count" : stated;
    gyro.evidence = stated.empty() ? "" : stated + " as the file says; the data do not confirm it (fewer than three turns between rests)";
    if (triads.turns >= 3 && !triads.explained() && !(declared.contains("gyro.columns") && declared.contains("accel.columns")))
      gyro.open = fmt::format("gyro.columns: they leave {:.3g} deg of turns of {:.3g} deg unexplained; check the columns and their unit",
                              triads.error / unit::deg, triads.turned / unit::deg);
    else if (stated.empty())
      gyro.open = time.rate_hz ? "gyro.unit: fewer than three turns between rests, which would show it"
                               : "gyro.unit: turns cannot show it without a sampling rate; declare rate_hz";
  } else {
    gyro = gyro_unit(triads.gyro_scale(), interval_s, stated, whole_gyro);
  }
  declare_unit(declared, "gyro", gyro);
  settle_triad(table, triads.accel, accel, "accel", result.source.accel, result);
  settle_triad(table, triads.gyro, gyro, "gyro", result.source.gyro, result);
  if (!accel.evidence.empty()) result.evidence.push_back(fmt::format("accelerometers: {}: {}", names_of(table, triads.accel), accel.evidence));
  if (!gyro.evidence.empty()) result.evidence.push_back(fmt::format("gyros: {}: {}", names_of(table, triads.gyro), gyro.evidence));
  if (triads.explained())
    result.evidence.push_back(
        fmt::format("gyros explain {} turns of {:.3g} deg RMS to {:.2g} deg", triads.turns, triads.turned / unit::deg, triads.error / unit::deg));
}

/// Names that contradict the data are asked about.
void ask_about_names(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  if (has_role(table, triads.gyro, Role::accel) || has_role(table, triads.accel, Role::gyro))
    result.ambiguous.push_back(
        fmt::format("gyro.columns, accel.columns: by the turns {} are the gyros and {} the accelerometers; the names say otherwise",
                    names_of(table, triads.gyro), names_of(table, triads.accel)));
}

/// The temperature, by a column's name and its numbers.
void settle_temperature(const SignalTable& table, Inspection& result) {
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const Signal& signal = table.signals[i];
    if (hint_of(signal.name).role != Role::temperature || result.columns[i].role != "unused") continue;
    const auto [low, high] = std::minmax_element(signal.values.begin(), signal.values.end());
    if (!std::isfinite(*low) || !std::isfinite(*high) || *low == *high) continue;
    const NameHint hint = hint_of(signal.name);
    const bool other_unit = !hint.unknown.empty() || signal.name.ends_with("_F");
    const std::string stated = !signal.unit.empty() ? signal.unit : other_unit ? "raw" : hint.unit;
    const std::string unit = stated == "degC" || stated == "K" || stated == "raw" ? stated
                             : *low > -60 && *high < 150                          ? "degC"
                             : *low > 200 && *high < 430                          ? "K"
                                                                                  : "raw";
    result.columns[i].role = "temperature";
    result.columns[i].unit = unit;
    result.columns[i].evidence = fmt::format("its name, and {:.4g} to {:.4g}", *low, *high);
    result.evidence.push_back(fmt::format("temperature: {}: {:.4g} to {:.4g}: {}", name_of(table, i), *low, *high, unit));
    ThermalSource thermal;
    thermal.columns = {signal.column};
    thermal.unit = unit;
    result.source.gyro_temperature = result.source.accel_temperature = thermal;
    return;
  }
}

TimeGuess settle_time(const SignalTable& table, const Declarations& declared, Inspection& result) {
  TimeGuess time = declared_time(table, declared, recognize_time(table));
  for (const auto& [index, role] : {std::pair{time.column, "time"}, {time.fraction, "time"}})
    if (index) result.columns[*index] = {name_of(table, *index), role, time.source.unit, time.evidence};
  if (time.fraction) result.columns[*time.fraction].unit = time.source.fraction_unit;
  result.source.time = time.source;
  if (!time.column || time.source.unit == "sample") result.source.rate_hz = time.rate_hz;
  result.rate_hz = time.rate_hz;
  result.evidence.push_back("time: " + time.evidence);
  if (!time.others.empty()) result.evidence.back() += fmt::format(" (could be time as well: {})", fmt::join(time.others, ", "));
  if (!time.open.empty()) result.ambiguous.push_back(time.open);
  return time;
}

/// Columns of numbers that some rows have none in: none of them is a reading.
std::string columns_with_holes(const SignalTable& table) {
  constexpr double most = 0.5;  // of the rows: else it is no column of numbers
  std::string text;
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const std::vector<double>& values = table.signals[i].values;
    const auto is_hole = [](double v) { return !std::isfinite(v); };
    const auto holes = std::count_if(values.begin(), values.end(), is_hole);
    if (holes == 0 || static_cast<double>(holes) > most * static_cast<double>(values.size())) continue;
    const auto first = std::find_if(values.begin(), values.end(), is_hole) - values.begin() + 1;
    text += fmt::format("; {} has no finite number in {} {}, first in row {}", name_of(table, i), holes, holes == 1 ? "row" : "rows", first);
  }
  return text;
}

std::vector<std::int64_t> from_the_first(std::vector<std::int64_t> time_ns) {
  for (std::size_t i = time_ns.size(); i-- > 0;) time_ns[i] -= time_ns.front();
  return time_ns;
}

void add_times(const std::vector<std::int64_t>& time_ns, Inspection& result) {
  if (!time_ns.empty()) result.duration_s = 1e-9 * static_cast<double>(time_ns.back());
  if (!result.triads) return;
  for (const Range& rest : result.triads->rests)
    result.rests_s.push_back({1e-9 * static_cast<double>(time_ns[rest.begin]), 1e-9 * static_cast<double>(time_ns[rest.end - 1])});
}

}  // namespace

Inspection inspect(const SignalTable& table, const Declarations& declared) {
  check_declarations(declared);
  if (table.rows() < 20) throw Error(fmt::format("{}: {} rows; expected at least 20 to recognize anything", table.file, table.rows()));
  Inspection result;
  result.file = table.file;
  result.topic = result.source.topic = table.topic;
  result.source.file = std::filesystem::path(table.file).filename().string();
  result.format = table.format;
  result.rows = table.rows();
  for (std::size_t i = 0; i < table.signals.size(); ++i) result.columns.push_back({name_of(table, i), "unused", "", ""});

  const TimeGuess time = settle_time(table, declared, result);
  TimeGuess assumed = time;  // what does not depend on the rate is found without it
  if (!assumed.rate_hz) assumed.rate_hz = 100;
  const std::vector<std::int64_t> time_ns = from_the_first(stamps_of(table, assumed));
  if (time.column && time_ns.empty()) result.problems.push_back(fmt::format("{} has no stamp in some row", name_of(table, *time.column)));
  const ClockQuality clock = clock_quality(time_ns);
  const double interval_s = time.rate_hz ? 1 / *time.rate_hz : clock.interval_s;
  const DeclaredColumns columns = declared_columns(table, declared);
  if (clock.backward == 0 && !time_ns.empty()) result.triads = find_triads(table, ascending(time_ns), time, columns, gyro_scales(interval_s), result);
  if (clock.backward > 0) {
    result.problems.push_back(fmt::format("time runs backwards {} times, first at row {}; expected one recording, with one clock", clock.backward,
                                          clock.first_backward + 1));
  } else if (!result.triads) {
    result.ambiguous.push_back(
        "accel.columns, gyro.columns: no pair of triads behaves like accelerometers and gyros, and the names do not identify them; name the columns" +
        columns_with_holes(table));
  } else {
    const std::string axes = settle_axes(table, declared, *result.triads, result);
    settle_units(table, *result.triads, time, declared, result);
    if (!columns.gyro && !columns.accel) ask_about_names(table, *result.triads, result);
    if (!axes.empty()) result.evidence.push_back(axes);
    settle_temperature(table, result);
    add_support(table, *result.triads, result);
  }
  if (time.rate_hz) {
    add_clock(clock, result);
    add_times(time_ns, result);
  }
  for (const SignalPart& part : table.parts)
    if (!part.open.empty()) result.ambiguous.push_back(fmt::format("{} (of {}{})", part.open, part.file, part.topic));
  result.evidence.insert(result.evidence.end(), table.notes.begin(), table.notes.end());
  if (!time.open.empty()) result.ambiguous = {time.open};  // what else is asked follows from it
  return result;
}

Session inspected_session(const Inspection& inspection, const Site& site) {
  Session session;
  session.imu.name = std::filesystem::path(inspection.file).stem().string();
  session.site = site;
  if (!site.latitude && !site.given_gravity) {
    session.site.given_gravity = 9.806;
    session.site.given_gravity_sigma = 0.015;  // 9.780 at the equator to 9.832 at the poles
  }
  session.recordings = {inspection.source};
  return session;
}

}  // namespace imulab
