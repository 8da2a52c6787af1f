// imulab export CALIBRATION --to TARGET
#include "apps/imulab/command.hpp"
#include "apps/imulab/export_c_header.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/export/target.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/text/file.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace imulab::command {

namespace {

struct Options {
  std::string calibration, target, output = "-";
  bool allow_undetermined = false, json = false;
  CHeaderArguments c_header;
};

std::string text_of(const ExportTarget& target, const Calibration& calibration, const Options& o) {
  if (target.name != "c-header") {
    if (o.c_header.given()) throw Error("--to " + o.target + ": has none of the options of c-header; expected --to c-header");
    return errors_at(o.calibration, [&] { return target.text(calibration); });
  }
  const CHeaderOptions options = c_header_options(o.c_header, calibration);
  for (const std::string& assumed : assumed_readings(options, calibration)) warn(o.calibration + ": " + assumed);
  return errors_at(o.calibration, [&] { return c_header(calibration, options); });
}

void run(const Options& o) {
  const Calibration calibration = read_usable(o.calibration, o.allow_undetermined);
  const ExportTarget& target = export_target(o.target);
  const std::string text = text_of(target, calibration, o);
  const std::vector<std::string> lost = target.left_out(calibration);
  for (const std::string& left_out : lost) warn(o.calibration + ": " + left_out);
  if (o.json && o.output == "-") throw Error("--json: standard output has the export; expected -o FILE");
  write_whole(o.output, text);
  if (o.json) fmt::print("{}", fields_json({{{"target", o.target}, {"file", o.output}, {"left_out", lost}}}));
}

}  // namespace

void add_export(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("export", "Write a calibration for other programs");
  std::vector<std::string> names, help;
  for (const ExportTarget& target : export_targets()) {
    names.emplace_back(target.name);
    help.push_back(fmt::format("{}: {}", target.name, target.summary));
  }
  verb.option("CALIBRATION", o->calibration, "calibration.json").required();
  verb.option("--to TARGET", o->target, fmt::format("{}", fmt::join(help, "; "))).required().one_of(names);
  verb.option("-o,--output FILE", o->output, "the file to write; - for standard output").show_default();
  add_allow_undetermined(verb, o->allow_undetermined);
  add_c_header_options(verb, o->c_header);
  verb.flag("--json", o->json, "print what was written and what it leaves out as JSON");
  verb.example("imulab export calibration.json --to c-header -o imu_calibration.h");
  verb.example("imulab export calibration.json --to c-header --input-accel g -o imu.h");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
