#include "imulab/inspection/inspection.hpp"

#include "imulab/error.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/even_rows.hpp"
#include "imulab/inspection/evidence.hpp"
#include "imulab/inspection/holes.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/inspection/purpose.hpp"
#include "imulab/inspection/time.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/integers.hpp"
#include "imulab/units.hpp"

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

std::string names_of(const SignalTable& table, const SignalTriad& triad) {
  return fmt::format("{}, {}, {}", column_name(table, triad[0]), column_name(table, triad[1]), column_name(table, triad[2]));
}

/// The unit that the file or the column's name states for a triad.
std::string stated_unit(const SignalTable& table, const SignalTriad& triad) {
  const Signal& signal = table.signals[triad[0]];
  const NameHint hint = hint_of(signal.name);
  return !signal.unit.empty() ? signal.unit : !hint.unknown.empty() ? hint.unknown : hint.unit;
}

/// What may be declared where both triads together are left-handed. Names of axes rule out that both are in another order than x, y, z.
std::string left_handed_advice(const SignalTable& table, const TriadEvidence& triads) {
  bool named = true;
  for (const SignalTriad* triad : {&triads.gyro, &triads.accel})
    for (std::size_t axis = 0; axis < 3; ++axis) named = named && hint_in(table, (*triad)[axis]).axis == static_cast<int>(axis);
  const std::string reversed = "the data do not show which sensor is reversed; declare it (accel.axes, or gyro.axes = +x,+y,-z)";
  return named ? "; " + reversed
               : "; if the columns of both are in another order than x, y, z, declare accel.columns and gyro.columns in that order; else " + reversed;
}

/// The gyros' columns in the order of the accelerometers' axes, where they are merely exchanged; what speaks against them otherwise.
std::string settle_axes(const SignalTable& table, const Declarations& declared, TriadEvidence& triads, Inspection& result) {
  result.source.gyro.axes = declared_axes(declared, "gyro");
  result.source.accel.axes = declared_axes(declared, "accel");
  if (result.source.gyro.axes || result.source.accel.axes) return "as declared";
  if (!triads.explained()) return {};
  const std::string wrong = wrong_axes(*triads.gyro_matrix);
  if (wrong.empty()) return "the gyros turn as gravity does, right-handed";
  SignalTriad ordered = triads.gyro;
  bool reversed = false;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Eigen::Index from = 0;
    triads.gyro_matrix->row(axis).cwiseAbs().maxCoeff(&from);
    ordered[static_cast<std::size_t>(axis)] = triads.gyro[static_cast<std::size_t>(from)];
    reversed = reversed || (*triads.gyro_matrix)(axis, from) < 0;
  }
  if (reversed) {
    result.ask({"gyro.axes", wrong + left_handed_advice(table, triads)});
    return {};
  }
  Matrix3d exchange = Matrix3d::Zero();
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (Eigen::Index from = 0; from < 3; ++from)
      exchange(from, axis) = ordered[static_cast<std::size_t>(axis)] == triads.gyro[static_cast<std::size_t>(from)] ? 1 : 0;
  triads.gyro_matrix = *triads.gyro_matrix * exchange;
  triads.gyro = ordered;
  return fmt::format("{}; taken as x, y, z: {}", wrong, names_of(table, ordered));
}

void settle_triad(const SignalTable& table, const SignalTriad& triad, const UnitGuess& guess, const std::string& role, TriadSource& source,
                  Inspection& result) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ColumnFinding& column = result.columns[triad[axis]];
    column.role = role + "." + "xyz"[axis];
    column.unit = guess.open.empty() || guess.unit != "count" ? guess.unit : "unknown";
    column.evidence = !guess.evidence.empty() ? guess.evidence : guess.open.empty() ? "" : guess.open.line();
    source.columns.push_back(table.signals[triad[axis]].column);
  }
  source.unit = guess.unit;
  source.output = guess.output;
  for (const std::size_t i : triad)
    if (table.signals[i].integers != Integers::as_written) source.integers = table.signals[i].integers;
  if (source.integers != Integers::as_written)
    result.note(fmt::format("integers: {} are {}, some of which are printed with another sign: they lie, or jump, near 0 and its range",
                            names_of(table, triad), to_string(source.integers)));
  if (const std::size_t part = table.signals[triad[0]].table; part > 0) {
    if (!table.parts[part - 1].file.empty()) source.file = table.parts[part - 1].file;
    if (!table.parts[part - 1].topic.empty()) source.topic = table.parts[part - 1].topic;
    if (!(table.parts[part - 1].time == result.source.time)) source.time = table.parts[part - 1].time;
  }
  if (!guess.open.empty()) result.ask(guess.open);
}

UnitGuess accel_guess(const SignalTable& table, const TriadEvidence& triads, double interval_s) {
  const std::string stated = stated_unit(table, triads.accel);
  UnitGuess guess;
  const bool whole = whole_numbers(table, triads.accel);
  if (triads.offset_taken_out && whole && stated.empty()) {
    guess.evidence = fmt::format("readings at rest lie on a sphere of radius {:.5g} about a point far from zero: counts", triads.norm);
  } else if (!triads.rests.empty()) {
    return accel_unit(triads.norm, triads.norm_least, triads.norm_most, interval_s, stated, whole);
  } else if (stated.empty()) {
    guess.open = {"accel.unit", "no rest was found, which would show gravity"};
  } else {
    guess.unit = stated;
    guess.evidence = stated + " as the file says; no rest was found that would confirm it";
  }
  return guess;
}

UnitGuess gyro_guess(const SignalTable& table, const TriadEvidence& triads, const TimeGuess& time, double interval_s, bool columns_declared) {
  const std::string stated = stated_unit(table, triads.gyro);
  if (triads.explained() && time.rate_hz) return gyro_unit(triads.gyro_scale(), interval_s, stated, whole_numbers(table, triads.gyro));
  UnitGuess guess;
  guess.unit = stated.empty() ? "count" : stated;
  guess.evidence = stated.empty() ? "" : stated + " as the file says; the data do not confirm it (fewer than three turns between rests)";
  if (triads.turns >= 3 && !triads.explained() && !columns_declared)
    guess.open = {"gyro.columns",
                  fmt::format("they leave {:.3g} deg of turns of {:.3g} deg unexplained; check the columns and their unit", triads.error / unit::deg,
                              triads.turned / unit::deg),
                  "", Code::turns_unexplained};
  else if (stated.empty())
    guess.open = {"gyro.unit", time.rate_hz ? "fewer than three turns between rests, which would show it"
                                            : "turns cannot show it without a sampling rate; declare rate_hz"};
  const bool is_of_unit = !guess.open.empty() && guess.open.code != Code::turns_unexplained;
  if (const std::string noise = time.rate_hz && is_of_unit ? noise_by_unit(table, triads, interval_s) : ""; !noise.empty())
    guess.open.advice = "by the noise at rest " + noise;
  return guess;
}

/// Units of the triads that there are.
void settle_units(const SignalTable& table, const TriadEvidence& triads, const TimeGuess& time, const Declarations& declared, Inspection& result) {
  const double interval_s = time.rate_hz ? 1 / *time.rate_hz : 0;
  UnitGuess accel, gyro;
  if (triads.has_accel) accel = accel_guess(table, triads, interval_s);
  if (triads.has_gyro) gyro = gyro_guess(table, triads, time, interval_s, declared.contains("gyro.columns") && declared.contains("accel.columns"));
  declare_unit(declared, "accel", accel);
  declare_unit(declared, "gyro", gyro);
  const bool as_increments = triads.has_accel && accel.open.empty() && accel.output == Output::increment;
  if (as_increments && triads.has_gyro && gyro.open.empty() && gyro.output == Output::rate && gyro.unit != "count" && !triads.explained() &&
      !declared.contains("gyro.output"))  // a sensor gives both alike
    gyro.open = {"gyro.output", fmt::format("the accelerometers give increments; do gyros in {} give rates (--set gyro.output=rate), or increments "
                                            "(--set gyro.unit=rad)",
                                            gyro.unit)};
  if (time.by_rate_alone) {
    const bool by_turns = triads.explained() && gyro.open.empty() && gyro.output == Output::rate && gyro.unit != "count";
    const bool by_gravity = !triads.rests.empty() && triads.has_accel && accel.open.empty() && accel.output == Output::increment;
    const bool count_declared = declared.contains("gyro.unit") && gyro.unit == "count";
    if (!by_turns && !by_gravity && !count_declared) {
      result.ask(
          {"time.unit", time.evidence + "; only the rate speaks for it: whole numbers may be ticks, too (declare time.unit, or time.ticks_per_s)"});
      if (triads.turns >= 3) gyro.open = {};  // it follows from the clock
    }
  }
  if (triads.has_accel) settle_triad(table, triads.accel, accel, "accel", result.source.accel, result);
  if (triads.has_gyro) settle_triad(table, triads.gyro, gyro, "gyro", result.source.gyro, result);
  if (triads.has_accel && !accel.evidence.empty()) result.note(fmt::format("accelerometers: {}: {}", names_of(table, triads.accel), accel.evidence));
  if (triads.has_gyro && !gyro.evidence.empty()) result.note(fmt::format("gyros: {}: {}", names_of(table, triads.gyro), gyro.evidence));
  if (triads.explained()) result.findings.add<Code::turns_explained>(triads.turns, triads.turned / unit::deg, triads.error / unit::deg);
}

/// Names that contradict the data are asked about.
void ask_about_names(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  if (!triads.has_gyro || !triads.has_accel) return;
  if (has_role(table, triads.gyro, Role::accel) || has_role(table, triads.accel, Role::gyro))
    result.ask({"gyro.columns, accel.columns",
                fmt::format("by the turns {} are the gyros and {} the accelerometers; the names say otherwise; if the turns are right: --set "
                            "gyro.columns={} --set accel.columns={}",
                            names_of(table, triads.gyro), names_of(table, triads.accel), declared_as(table, triads.gyro),
                            declared_as(table, triads.accel))});
}

/// The temperature, by a column's name and its numbers.
void settle_temperature(const SignalTable& table, Inspection& result) {
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    const Signal& signal = table.signals[i];
    if (hint_of(signal.name).role != Role::temperature || result.columns[i].role != "unused") continue;
    const auto [low, high] = std::minmax_element(signal.values.begin(), signal.values.end());
    if (!std::isfinite(*low) || !std::isfinite(*high) || *low == *high) continue;
    const NameHint hint = hint_of(signal.name);
    const bool celsius = hint.unknown == "C" || hint.unknown == "℃", other_unit = (!hint.unknown.empty() && !celsius) || signal.name.ends_with("_F");
    const std::string stated = !signal.unit.empty() ? signal.unit : other_unit ? "raw" : hint.unit;
    const std::string unit = stated == "degC" || stated == "K" || stated == "raw" ? stated
                             : *low > -60 && *high < 150                          ? "degC"
                             : *low > 200 && *high < 430                          ? "K"
                                                                                  : "raw";
    result.columns[i].role = "temperature";
    result.columns[i].unit = unit;
    result.columns[i].evidence = fmt::format("its name, and {:.4g} to {:.4g}", *low, *high);
    result.note(fmt::format("temperature: {}: {:.4g} to {:.4g}: {}", column_name(table, i), *low, *high, unit));
    ThermalSource thermal;
    thermal.columns = {signal.column};
    thermal.unit = unit;
    result.source.gyro_temperature = result.source.accel_temperature = thermal;
    return;
  }
}

TimeGuess settle_time(const SignalTable& table, const Declarations& declared, Inspection& result) {
  TimeGuess time = declared_time(table, declared, recognize_time(table));
  for (const auto& [index, role] : {std::pair{time.column, "time"}, {time.fraction, "time"}, {time.replaced, "time"}})
    if (index) result.columns[*index] = {column_name(table, *index), role, time.source.unit, time.evidence};
  if (time.fraction) result.columns[*time.fraction].unit = time.source.fraction_unit;
  result.source.time = time.source;
  if (!time.column || time.source.unit == "sample") result.source.rate_hz = time.rate_hz;
  result.rate_hz = time.rate_hz;
  result.note("time: " + time.evidence + (time.others.empty() ? "" : fmt::format(" (could be time as well: {})", fmt::join(time.others, ", "))));
  if (!time.open.empty()) result.ask(time.open);
  return time;
}

/// The table, or `right` with its readings as the integers that they are, where the file prints them with the wrong sign.
const SignalTable& with_integers(const SignalTable& table, SignalTable& right) {
  std::vector<const std::vector<double>*> columns;
  for (const Signal& signal : table.signals) columns.push_back(&signal.values);
  const std::vector<Integers> kinds = integers_of(columns);
  if (kinds.empty()) return table;
  right = table;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    right.signals[i].integers = kinds[i];
    take_as(kinds[i], right.signals[i].values);
  }
  return right;
}

std::vector<std::int64_t> from_the_first(std::vector<std::int64_t> time_ns) {
  for (std::size_t i = time_ns.size(); i-- > 0;) time_ns[i] -= time_ns.front();
  return time_ns;
}

double rate_of_rows(const std::vector<std::int64_t>& time_ns) {
  return static_cast<double>(time_ns.size() - 1) / (1e-9 * static_cast<double>(time_ns.back() - time_ns.front()));
}

/// A logger that empties a buffer now and then, and stamps all of it at once.
bool in_bursts(const ClockQuality& clock, const std::vector<std::int64_t>& time_ns) {
  constexpr std::size_t longest_burst = 200;  // rows
  if (time_ns.size() < 2 || time_ns.back() <= time_ns.front()) return false;
  return clock.gaps * longest_burst > time_ns.size() && clock.interval_s * rate_of_rows(time_ns) < 0.5;
}

void add_times(const std::vector<std::int64_t>& time_ns, Inspection& result) {
  if (!time_ns.empty()) result.duration_s = 1e-9 * static_cast<double>(time_ns.back());
  if (!result.triads) return;
  for (const Range& rest : result.triads->rests)
    result.rests_s.push_back({1e-9 * static_cast<double>(time_ns[rest.begin]), 1e-9 * static_cast<double>(time_ns[rest.end - 1])});
}

}  // namespace

void Inspection::note(const std::string& evidence) { findings.add<Code::evidence>(evidence); }

void Inspection::ask(const Question& question) {
  Finding& asked = findings.add<Code::open_question>(Subject{question.key}, question.text);
  asked.code = question.code, asked.advice = question.advice;
}

Inspection inspect(const SignalTable& given, const Declarations& declared) {
  check_declarations(declared);
  if (given.rows() < 20) throw Error(fmt::format("{}: {} rows; expected at least 20 to recognize anything", given.file, given.rows()));
  SignalTable own;  // with the integers of the right sign where the file prints others, and with sums
  const SignalTable& table = with_sums(with_integers(given, own), own);
  Inspection result;
  result.file = table.file;
  result.topic = result.source.topic = table.topic;
  result.source.file = std::filesystem::path(table.file).filename().string();
  result.format = table.format;
  result.rows = table.rows();
  for (std::size_t i = 0; i < table.signals.size(); ++i) result.columns.push_back({column_name(table, i), "unused", "", ""});

  const TimeGuess time = settle_time(table, declared, result);
  TimeGuess assumed = time;  // what does not depend on the rate is found without it
  if (!assumed.rate_hz) assumed.rate_hz = 100;
  if (time.source.unit == "tick" && !time.source.ticks_per_s) assumed.source.ticks_per_s = *assumed.rate_hz * std::max(time.step, 1.0);
  const std::vector<std::int64_t> time_ns = from_the_first(stamps_of(table, assumed));
  if (time.column && time_ns.empty()) result.findings.add<Code::file_problem>(column_name(table, *time.column) + " has no stamp in some row");
  const ClockQuality clock = clock_quality(time_ns);
  const double interval_s = time.rate_hz ? 1 / *time.rate_hz : clock.interval_s;
  const DeclaredColumns columns = declared_columns(table, declared);
  const std::size_t questions = result.ambiguous().size();
  if (clock.backward == 0 && !time_ns.empty()) result.triads = find_triads(table, ascending(time_ns), time, columns, gyro_scales(interval_s), result);
  if (clock.backward > 0) {
    result.findings.add<Code::file_problem>(fmt::format("time runs backwards {} times, first at row {}; expected one recording, with one clock; {}",
                                                        clock.backward, clock.first_backward + 1, even_rows_advice()));
  } else if (const std::string holes = result.triads || result.ambiguous().size() > questions ? "" : holes_of_sensors(table); !holes.empty()) {
    result.findings.add<Code::file_problem>(holes);
  } else if (!result.triads && result.ambiguous().size() == questions) {
    result.ask(
        {"accel.columns, gyro.columns",
         "no pair of triads behaves like accelerometers and gyros, and the names do not identify both; name the columns of both, or of one that "
         "is alone" +
             std::string(declared.contains("gyro.unit") ? "" : ", and gyro.unit if the log has no three turns, which would show it") +
             words_about_holes(table)});
  } else if (result.triads) {
    const std::string axes = settle_axes(table, declared, *result.triads, result);
    settle_units(table, *result.triads, time, declared, result);
    if (!columns.gyro && !columns.accel) ask_about_names(table, *result.triads, result);
    if (!axes.empty()) result.findings.add<Code::axes_found>(axes);
    settle_temperature(table, result);
    add_support(table, ascending(time_ns), *result.triads, result);
    add_purpose(table, *result.triads, result);
  }
  if (time.rate_hz) {
    add_clock(clock, result);
    add_times(time_ns, result);
    if (clock.repeated > 0 && clock.backward == 0) take_even_rows(table, time_ns, result);
  }
  if (result.source.time.column && in_bursts(clock, time_ns))
    result.ask({"time.column", fmt::format("stamps come in bursts, {:.4g} s apart inside one, so that most of the time is in gaps; {}",
                                           clock.interval_s, even_rows_advice(rate_of_rows(time_ns)))});
  for (const SignalPart& part : table.parts)
    if (!part.open.empty()) result.ask({part.open.key, fmt::format("{} (of {}{})", part.open.text, part.file, part.topic)});
  for (const std::string& note : table.notes) result.note(note);
  if (time.open.empty()) return result;
  std::erase_if(result.findings, [](const Finding& f) { return f.severity == Severity::warning; });  // what else is asked follows from it
  result.ask(time.open);
  return result;
}

Session inspected_session(const Inspection& inspection, const Declarations& declared) {
  Session session;
  session.imu.name = std::filesystem::path(inspection.file).stem().string();
  session.imu.grade = declared_grade(declared);
  session.site = declared_site(declared);
  if (!session.site.latitude && !session.site.given_gravity) {
    session.site.given_gravity = gravity_anywhere, session.site.given_gravity_sigma = gravity_anywhere_sigma;
  }
  session.recordings = {inspection.source};
  return session;
}

}  // namespace imulab
