#include "imulab/procedure.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/calibration.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/grade.hpp"
#include "imulab/tasks/procedures.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace imulab::command {

namespace {

struct Output {
  std::string file = "-";
  bool json = false;
};

void write(const Output& output, const Session& session) {
  const std::string text = procedure_text(session);
  write_whole(output.file, output.json ? text::toml_as_json(text) : text);
}

void add_output(Verb& verb, Output& output) {
  verb.option("-o,--output FILE", output.file, "the file to write; - for standard output").writes().show_default();
  verb.option("--json", output.json, "write the procedure as JSON, for other programs");
}

void grade_option(Verb& verb, std::string& chosen) {
  std::vector<std::string> names;
  for (const Grade& of : grades()) names.emplace_back(of.name);
  verb.option("--grade GRADE", chosen, "grade of the IMU: its noise and the sizes of its errors").one_of(names).show_default();
}

/// A procedure by hand, with the options that all have.
struct ByHand {
  WarmUpOptions warm_up;  ///< of `handheld`: its `by_hand`
  std::uint64_t seed = 1;
  Output output;
};

void add_by_hand_options(Verb& verb, ByHand& a) {
  verb.option("--rest SECONDS", a.warm_up.by_hand.rest, "duration of each rest, except the first").in_range(0.1, 86400).show_default();
  grade_option(verb, a.warm_up.by_hand.grade);
  verb.option("--seed", a.seed, "random seed of the attitudes").show_default();
  add_output(verb, a.output);
}

void add_hand_held(Verb& verb) {
  const auto a = std::make_shared<ByHand>();
  a->warm_up.by_hand = HandHeldOptions();
  Verb& own = verb.verb("handheld", "By hand: rests at random attitudes, no rig");
  own.option("--poses", a->warm_up.by_hand.poses, "number of rests").show_default();
  add_by_hand_options(own, *a);
  own.example("imulab procedure handheld --poses 25 -o handheld.toml");
  own.does = [a] { write(a->output, hand_held_procedure(a->warm_up.by_hand, a->seed)); };
}

void add_warm_up(Verb& verb) {
  const auto a = std::make_shared<ByHand>();
  Verb& own = verb.verb("warm-up", "By hand, from the freezer: also how all follows the temperature");
  own.option("--cold DEGC", a->warm_up.from, "temperature at the begin").in_range(-100, 200).show_default();
  own.option("--room DEGC", a->warm_up.to, "temperature of the room").in_range(-100, 200).show_default();
  own.option("--minutes MINUTES", a->warm_up.minutes, "duration of the warm-up, to 95 % of the way").in_range(1, 600).show_default();
  add_by_hand_options(own, *a);
  own.example("imulab procedure warm-up -o warm-up.toml");
  own.does = [a] { write(a->output, warm_up_procedure(a->warm_up, a->seed)); };
}

void add_on_table(Verb& verb, const TableProcedure& procedure) {
  struct Arguments {
    TableProcedureOptions options;
    double table_arcsec;
    Output output;
  };
  const auto a = std::make_shared<Arguments>(Arguments{procedure.options, procedure.options.table / unit::arcsec, {}});
  Verb& own = verb.verb(std::string(procedure.name), std::string(procedure.summary));
  own.option("--rest SECONDS", a->options.rest, "duration of each rest").in_range(0.1, 86400).show_default();
  own.option("--table ARCSEC", a->table_arcsec, "declared size of the table's errors: angles, orthogonality, zeros; one sigma")
      .in_range(0, 1296000)
      .show_default();
  grade_option(own, a->options.grade);
  add_output(own, a->output);
  own.example(fmt::format("imulab procedure {0} -o {0}.toml", procedure.name));
  own.does = [a, make = procedure.make] {
    a->options.table = a->table_arcsec * unit::arcsec;
    write(a->output, make(a->options));
  };
}

std::vector<RigKind> machines_in(const std::string& list) {
  std::vector<RigKind> out;
  std::istringstream names(list);
  for (std::string name; std::getline(names, name, ',');) {
    out.push_back(RigKind::none);
    for (const RigKind kind : {RigKind::chamber, RigKind::rate_table, RigKind::centrifuge})
      if (name == to_string(kind)) out.back() = kind;
    if (out.back() == RigKind::none) throw OptionError("machines", name + "; expected chamber, rate_table or centrifuge");
  }
  return out;
}

void add_dai_unit(Verb& verb) {
  struct Arguments {
    DaiUnitOptions options;
    std::string thermal = "three", machines = "chamber,rate_table,centrifuge";
    Output output;
  };
  const auto a = std::make_shared<Arguments>();
  Verb& own = verb.verb("dai-unit", "Chamber, rate table and centrifuge: all coefficients");
  own.option("--record SECONDS", a->options.record, "duration of each point").in_range(0.1, 86400).show_default();
  own.option("--rate-hz HZ", a->options.rate_hz, "sampling rate").in_range(0.1, 1e6).show_default();
  own.option("--thermal KIND", a->thermal,
             "thermal readings: three sensors at each triad; one; resonance: the gyros' frequencies, and three sensors at the accelerometers")
      .one_of({"three", "one", "resonance"})
      .show_default();
  own.option("--machines LIST", a->machines,
             "the machines to use, with commas: chamber (15 points, 0 to 70 degC), rate_table (246 points, up to 400 deg/s), centrifuge (42 points, "
             "up to 30 g)")
      .show_default();
  grade_option(own, a->options.grade);
  own.option("--both-ways", a->options.both_ways, "the chamber warms and cools: 29 points");
  add_output(own, a->output);
  own.example("imulab procedure dai-unit -o dai-unit.toml");
  own.does = [a] {
    for (const ThermalSensors sensors : {ThermalSensors::three, ThermalSensors::one, ThermalSensors::resonance})
      if (to_string(sensors) == a->thermal) a->options.thermal = sensors;
    a->options.machines = machines_in(a->machines);
    write(a->output, dai_unit_procedure(a->options));
  };
}

// ---- which one?

void list_procedures() {
  print(standard_procedures_text() + "\n" +
        text::wrapped(
            "",
            "Both triads: biases, scale factors and misalignments of accelerometers and gyros. imulab procedure which says how well, for what "
            "you have; imulab procedure NAME -o FILE writes one, ready to edit."));
}

struct WhichArguments {
  std::string rig, sensors;
  std::optional<std::string> require;
};

void show_which(const WhichArguments& a) {
  std::vector<Requirement> requirements;
  if (a.require) requirements = errors_of_option("require", [&] { return parse_requirements(*a.require); });
  std::string text;
  bool met = false;
  for (const ProcedureChoice& choice : procedure_choices(a.rig, a.sensors)) {
    const Prediction prediction = predict(choice, requirements);
    met = met || prediction.missed.empty();
    text += (text.empty() ? "" : "\n") + procedure_text(choice, prediction, a.require.has_value());
  }
  print(text);
  if (!met) throw Unsupported("none of these procedures meets what is required; imulab plan and longer rests may (docs/start/choose.md)");
}

void add_which(Verb& verb) {
  const auto a = std::make_shared<WhichArguments>();
  Verb& own = verb.verb("which", "Which procedure: time needed and uncertainties reached, by what you have");
  own.option(
         "--have RIG", a->rig,
         "what moves the IMU: hands; one-axis, two-axis, three-axis: a table with so many axes; chamber: with a rate table; centrifuge: with both")
      .one_of({std::begin(rigs_that_one_has), std::end(rigs_that_one_has)});
  own.option("--sensors KIND", a->sensors, "mems; fog: fiber-optic gyros, tactical grade; rlg: ring laser gyros, navigation grade")
      .one_of({std::begin(sensors_that_one_has), std::end(sensors_that_one_has)});
  own.option("--require REQUIREMENTS", a->require, "limits; states which procedures meet them; exit code 1 if none does");
  own.example("imulab procedure which --have hands --sensors mems");
  own.example("imulab procedure which --sensors fog --require \"gyro.bias <= 0.1 deg/h\"");
  own.does = [a] { show_which(*a); };
}

}  // namespace

void add_procedure(Verb& app) {
  Verb& verb = app.verb("procedure", "List the standard procedures, or write one as TOML, ready to edit");
  verb.example("imulab procedure zhang-24 | imulab predict -");
  verb.does = list_procedures;
  for (const TableProcedure& procedure : table_procedures()) add_on_table(verb, procedure);
  add_hand_held(verb);
  add_warm_up(verb);
  add_dai_unit(verb);
  add_which(verb);
}

}  // namespace imulab::command
