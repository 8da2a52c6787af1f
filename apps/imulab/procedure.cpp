#include "imulab/rig/procedure.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/toml_fields.hpp"

#include <fmt/core.h>

#include <memory>

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

void add_hand_held(Verb& verb) {
  struct Arguments {
    HandHeldOptions options;
    std::uint64_t seed = 1;
    Output output;
  };
  const auto a = std::make_shared<Arguments>();
  Verb& hand_held = verb.verb("handheld", "By hand: rests at random attitudes, no rig");
  hand_held.option("--poses", a->options.poses, "number of rests").show_default();
  hand_held.option("--seed", a->seed, "random seed of the attitudes").show_default();
  add_output(hand_held, a->output);
  hand_held.example("imulab procedure handheld --poses 25 -o handheld.toml");
  hand_held.does = [a] { write(a->output, hand_held_procedure(a->options, a->seed)); };
}

void add_on_table(Verb& verb, const TableProcedure& procedure) {
  struct Arguments {
    TableProcedureOptions options;
    double table_arcsec;
    Output output;
  };
  const auto a = std::make_shared<Arguments>(Arguments{procedure.options, procedure.options.table / unit::arcsec, {}});
  Verb& own = verb.verb(std::string(procedure.name), std::string(procedure.summary));
  own.option("--rest", a->options.rest, "seconds of each rest").in_range(0.1, 86400).show_default();
  own.option("--table", a->table_arcsec, "declared uncertainty of the table's angles, orthogonality and zeros, one sigma, arcsec")
      .in_range(0, 1296000)
      .show_default();
  add_output(own, a->output);
  own.example(fmt::format("imulab procedure {0} -o {0}.toml", procedure.name));
  own.does = [a, make = procedure.make] {
    a->options.table = a->table_arcsec * unit::arcsec;
    write(a->output, make(a->options));
  };
}

void add_dai_unit(Verb& verb) {
  struct Arguments {
    DaiUnitOptions options;
    std::string thermal = "three";
    Output output;
  };
  const auto a = std::make_shared<Arguments>();
  Verb& own = verb.verb("dai-unit", "Chamber, rate table and centrifuge: all coefficients");
  own.option("--record", a->options.record, "seconds recorded at each point").in_range(0.1, 86400).show_default();
  own.option("--rate-hz", a->options.rate_hz, "samples per second").in_range(0.1, 1e6).show_default();
  own.option("--thermal KIND", a->thermal,
             "thermal readings: three sensors at each triad; one; resonance: the gyros' frequencies, and three sensors at the accelerometers")
      .one_of({"three", "one", "resonance"})
      .show_default();
  own.option("--both-ways", a->options.both_ways, "the chamber warms and cools");
  add_output(own, a->output);
  own.example("imulab procedure dai-unit -o dai-unit.toml");
  own.does = [a] {
    for (const ThermalSensors sensors : {ThermalSensors::three, ThermalSensors::one, ThermalSensors::resonance})
      if (to_string(sensors) == a->thermal) a->options.thermal = sensors;
    write(a->output, dai_unit_procedure(a->options));
  };
}

}  // namespace

void add_procedure(Verb& app) {
  Verb& verb = app.verb("procedure", "Write a standard procedure as TOML, ready to edit");
  verb.example("imulab procedure zhang-24 | imulab predict -");
  for (const TableProcedure& procedure : table_procedures()) add_on_table(verb, procedure);
  add_hand_held(verb);
  add_dai_unit(verb);
}

}  // namespace imulab::command
