#include "imulab/rig/procedure.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/session_file.hpp"

#include <fmt/core.h>

#include <memory>

namespace imulab::command {

namespace {

void write(const std::string& output, const Session& session) {
  const std::string text = procedure_text(session);
  if (output == "-") {
    fmt::print("{}", text);
  } else {
    write_whole(output, text);
  }
}

void add_output(CLI::App& verb, std::string& output) {
  verb.add_option("-o,--output", output, "the file to write; - for standard output")->capture_default_str();
}

void add_hand_held(CLI::App& verb) {
  struct Arguments {
    HandHeldOptions options;
    std::uint64_t seed = 1;
    std::string output = "-";
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* const hand_held = verb.add_subcommand("hand-held", "A unit turned by hand: rests at random attitudes, no rig");
  hand_held->add_option("--poses", a->options.poses, "number of rests")->capture_default_str();
  hand_held->add_option("--seed", a->seed, "another seed, other attitudes")->capture_default_str();
  add_output(*hand_held, a->output);
  hand_held->callback([a] { write(a->output, hand_held_procedure(a->options, a->seed)); });
}

void add_turntable(CLI::App& verb, const char* name, const char* about, Session (*procedure)(const TableProcedureOptions&)) {
  struct Arguments {
    TableProcedureOptions options;
    double table_arcsec = TableProcedureOptions{}.table / unit::arcsec;
    std::string output = "-";
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* const own = verb.add_subcommand(name, about);
  own->add_option("--rest", a->options.rest, "seconds of each rest")->capture_default_str();
  own->add_option("--table", a->table_arcsec, "the table's declared angles, orthogonality and zero, one sigma in arcsec")->capture_default_str();
  add_output(*own, a->output);
  own->callback([a, procedure] {
    a->options.table = a->table_arcsec * unit::arcsec;
    write(a->output, procedure(a->options));
  });
}

void add_dai_unit(CLI::App& verb) {
  struct Arguments {
    DaiUnitOptions options;
    std::string thermal = "three", output = "-";
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* const own = verb.add_subcommand("dai-unit", "Chamber, rate table and centrifuge: all coefficients of a whole unit");
  own->add_option("--record", a->options.record, "seconds recorded at each point")->capture_default_str();
  own->add_option("--rate-hz", a->options.rate_hz, "samples a second")->capture_default_str();
  own->add_option("--thermal", a->thermal,
                  "thermal readings: three sensors at each triad; one; resonance: the gyros' frequencies, and three sensors at the accelerometers")
      ->check(CLI::IsMember({"three", "one", "resonance"}))
      ->capture_default_str();
  own->add_flag("--both-ways", a->options.both_ways, "the chamber goes up and down");
  add_output(*own, a->output);
  own->callback([a] {
    for (const ThermalSensors sensors : {ThermalSensors::three, ThermalSensors::one, ThermalSensors::resonance})
      if (to_string(sensors) == a->thermal) a->options.thermal = sensors;
    write(a->output, dai_unit_procedure(a->options));
  });
}

}  // namespace

void add_procedure(CLI::App& app) {
  CLI::App* const verb = app.add_subcommand("procedure", "A standard procedure as TOML, ready to edit");
  verb->require_subcommand(1);
  add_turntable(*verb, "six-position", "Turntable: each body axis up and down", six_position_procedure);
  add_turntable(*verb, "zhang-24", "Turntable: five turns each way about each axis, then 24 positions", zhang_24_procedure);
  add_turntable(*verb, "cheng-path", "Turntable: 20 turns of 90 and 180 deg between rests", cheng_path_procedure);
  add_hand_held(*verb);
  add_dai_unit(*verb);
}

}  // namespace imulab::command
