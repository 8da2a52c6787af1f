#include "imulab/tasks/procedures.hpp"

#include "imulab/estimate/method.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/procedure.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace imulab {

namespace {

/// "4 min", "7.9 h"
std::string rough_time(double seconds) {
  return seconds < 5400 ? fmt::format("{:.0f} min", seconds / 60.0) : fmt::format("{:.1f} h", seconds / unit::hour);
}

Session table_procedure(std::string_view name) {
  const TableProcedure& found = *std::ranges::find(table_procedures(), name, &TableProcedure::name);
  return found.make(found.options);
}

constexpr std::array all_procedures{
    StandardProcedure{"handheld", "hands", "both triads", [] { return hand_held_procedure({}, 1); }},
    StandardProcedure{"warm-up", "hands, a freezer", "both, over temperature", [] { return warm_up_procedure({}, 1); }},
    StandardProcedure{"ferraris", "hands, a square box", "both triads, coarse", [] { return table_procedure("ferraris"); }},
    StandardProcedure{"six-position", "table, 2 axes", "accelerometers", [] { return table_procedure("six-position"); }},
    StandardProcedure{"two-axis", "table, 2 axes", "both triads", [] { return table_procedure("two-axis"); }},
    StandardProcedure{"zhang-24", "table, 3 axes", "both triads", [] { return table_procedure("zhang-24"); }},
    StandardProcedure{"cheng-path", "3 axes, angles unused", "both triads", [] { return table_procedure("cheng-path"); }},
    StandardProcedure{"dai-unit", "chamber, rate table, arm", "all coefficients", [] { return dai_unit_procedure({}); }},
};

// ---- by rig and sensors

/// A kind of sensors: the grade that stands for it, how long its rests are on a table and by hand, and the table that suits it.
struct Sensors {
  std::string_view name;
  const char* grade;
  double rest, rest_by_hand;  ///< s
  double table_arcsec;
};
constexpr std::array all_sensors{Sensors{"mems", "mems", 10, 4, 60}, Sensors{"fog", "tactical", 30, 20, 10}, Sensors{"rlg", "navigation", 60, 60, 2}};

ProcedureChoice by_hand(const Sensors& of) {
  HandHeldOptions options;
  options.grade = of.grade, options.rest = of.rest_by_hand;
  return {"hands", of.name, fmt::format("imulab procedure handheld --grade {} --rest {:g}", of.grade, options.rest), "handheld",
          hand_held_procedure(options, 1)};
}

ProcedureChoice on_table(std::string_view rig, std::string_view name, const Sensors& of) {
  const TableProcedure& found = *std::ranges::find(table_procedures(), name, &TableProcedure::name);
  TableProcedureOptions options = found.options;
  options.grade = of.grade, options.rest = of.rest, options.table = of.table_arcsec * unit::arcsec;
  return {rig, of.name, fmt::format("imulab procedure {} --grade {} --rest {:g} --table {:g}", name, of.grade, of.rest, of.table_arcsec), "turntable",
          found.make(options)};
}

ProcedureChoice on_machines(std::string_view rig, std::vector<RigKind> machines, const Sensors& of) {
  DaiUnitOptions options;
  options.grade = of.grade, options.machines = std::move(machines);
  std::string command = fmt::format("imulab procedure dai-unit --grade {}", of.grade);
  std::string_view before = " --machines ";
  for (const RigKind kind : options.machines) {
    if (options.machines == DaiUnitOptions{}.machines) break;  // as without the option
    command += fmt::format("{}{}", before, to_string(kind));
    before = ",";
  }
  Session procedure = dai_unit_procedure(options);
  return {rig, of.name, std::move(command), "whole-unit", std::move(procedure)};
}

ProcedureChoice choice_of(std::string_view rig, const Sensors& of) {
  if (rig == "hands") return by_hand(of);
  if (rig == "two-axis") return on_table(rig, "two-axis", of);
  if (rig == "three-axis") return on_table(rig, "zhang-24", of);
  if (rig == "one-axis") return on_machines(rig, {RigKind::rate_table}, of);
  if (rig == "chamber") return on_machines(rig, {RigKind::chamber, RigKind::rate_table}, of);
  return on_machines(rig, {RigKind::chamber, RigKind::rate_table, RigKind::centrifuge}, of);
}

std::string reached_cell(std::string_view triad, std::string_view term, const Prediction& prediction) {
  const std::string worst = worst_text(fmt::format("{}.{}", triad, term),
                                       [&](CoefficientIndex index) { return sigma_of(index, prediction.coefficients, prediction.sigma); });
  return worst.empty() ? "-" : worst;
}

}  // namespace

std::span<const StandardProcedure> standard_procedures() { return all_procedures; }

double duration_of(const Session& procedure) {
  std::map<std::string, double> ends;  // each recording has its own clock
  for (const Step& step : procedure.steps) ends[step.recording] = std::max(ends[step.recording], step.end);
  double seconds = 0;
  for (const auto& [file, end] : ends) seconds += end;
  return seconds;
}

std::string standard_procedures_text() {
  std::string text = fmt::format("{:<13} {:<24} {:>6}  {:<10} {}\n", "name", "what you need", "time", "grade", "what it gives");
  for (const StandardProcedure& p : all_procedures) {
    const Session session = p.make();
    text +=
        fmt::format("{:<13} {:<24} {:>6}  {:<10} {}\n", p.name, p.needs, rough_time(duration_of(session)), session.imu.grade.value_or(""), p.gives);
  }
  return text;
}

std::vector<ProcedureChoice> procedure_choices(std::string_view rig, std::string_view sensors) {
  std::vector<ProcedureChoice> out;
  for (const std::string_view has : rigs_that_one_has)
    for (const Sensors& of : all_sensors)
      if ((rig.empty() || rig == has) && (sensors.empty() || sensors == of.name)) out.push_back(choice_of(has, of));
  return out;
}

Prediction predict(const ProcedureChoice& choice, const std::vector<Requirement>& requirements) {
  PredictionOptions options;
  options.advice = false;
  Prediction out = predict(method(choice.method), choice.procedure, options);
  out.missed = shortfalls(out, requirements);
  return out;
}

std::string procedure_row(const ProcedureChoice& choice, const Prediction& p) {
  std::string row = fmt::format("| {} | {} | {} ", choice.rig, choice.sensors, rough_time(duration_of(choice.procedure)));
  for (const char* triad : {"accel", "gyro"})
    for (const char* term : {"offset", "matrix.diagonal", "matrix.off_diagonal"}) row += fmt::format("| {} ", reached_cell(triad, term, p));
  return row + "|\n";
}

std::string procedure_text(const ProcedureChoice& choice, const Prediction& p, bool judged) {
  std::string text = fmt::format("{}, {}: {}, method {}{}\n", choice.rig, choice.sensors, rough_time(duration_of(choice.procedure)), choice.method,
                                 !judged            ? ""
                                 : p.missed.empty() ? ": met"
                                                    : ": not met");
  text += reached_text([&](CoefficientIndex index) { return sigma_of(index, p.coefficients, p.sigma); });
  for (const Shortfall& missed : p.missed) text += text::wrapped("  ", shortfall_text(missed));
  const bool by_hand = choice.rig == "hands";
  text += fmt::format("  misalignments in {}\n", by_hand ? "the accelerometers' own axes" : "the axes of the machine, which the IMU's mount adds to");
  return text + fmt::format("  $ {}\n", choice.command);
}

}  // namespace imulab
