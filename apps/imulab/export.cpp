// imulab export CALIBRATION --to TARGET
#include "apps/imulab/command.hpp"
#include "apps/imulab/export_c_header.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/export/target.hpp"
#include "imulab/formats/noise/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

constexpr const char* all_targets = "all";

/// An option that only some targets have.
struct TargetOption {
  std::string name;
  Option option;
  std::vector<std::string_view> targets;
};

struct Options {
  std::string calibration, target, output = "-", noise, axes = "worst";
  bool allow_undetermined = false, force = false, json = false;
  ExportOptions choices;
  CHeaderArguments c_header;
  std::vector<TargetOption> of_targets;
};

void check_options(const Options& o) {
  for (const TargetOption& of : o.of_targets)
    if (of.option.given() && o.target != all_targets && std::find(of.targets.begin(), of.targets.end(), o.target) == of.targets.end())
      throw Error(fmt::format("{}: {} has none; expected one of the targets {}", of.name, o.target, text::listed(of.targets)));
  if (o.c_header.given() && o.target != all_targets && o.target != "c-header")
    throw Error("--to " + o.target + ": has none of the options of c-header; expected --to c-header");
}

std::string text_of(const ExportTarget& target, const ExportInput& input, const Options& o) {
  if (target.name != "c-header") return target.text(input);
  CHeaderOptions options = c_header_options(o.c_header, input.calibration);
  if (!is_stream(o.calibration)) options.calibration_sha256 = file_sum(o.calibration).sha256;
  for (const std::string& assumed : assumed_readings(options, input.calibration)) warn(input_name(o.calibration) + ": " + assumed);
  return c_header(input.calibration, options);
}

/// Writes one target's file, whole or not at all, after its warnings.
JsonFields write_target(const ExportTarget& target, const ExportInput& input, const Options& o, const std::string& output) {
  const std::string text = errors_at(input_name(o.calibration), [&] { return text_of(target, input, o); });
  const std::vector<std::string> lost = target.left_out(input);
  const std::string place = o.target == all_targets ? fmt::format("{}: {}", input_name(o.calibration), target.name) : input_name(o.calibration);
  if (o.target == all_targets && !lost.empty())
    warn(fmt::format("{}: does not hold all of the calibration: the head of {} lists what, and how much", place, output));
  else
    for (const std::string& sentence : lost) warn(fmt::format("{}: not held by {}: {}", place, target.name, sentence));
  if (target.warnings != nullptr)
    for (const std::string& warning : target.warnings(input)) warn(place + ": " + warning);
  write_whole(output, text);
  return {{{"target", std::string(target.name)}, {"file", output}, {"left_out", lost}}};
}

bool given(const Options& o, std::string_view name) {
  return std::any_of(o.of_targets.begin(), o.of_targets.end(), [&](const TargetOption& of) { return of.name == name && of.option.given(); });
}

struct PlannedExport {
  const ExportTarget* target;
  std::string imu_model, file;
};

/// Every target but those that need a noise that is not given; OpenVINS with both its models where none is asked for.
std::vector<PlannedExport> planned_exports(const ExportInput& input, const Options& o) {
  std::vector<PlannedExport> out;
  for (const ExportTarget& target : export_targets()) {
    if (target.needs_noise && input.noise == nullptr) {
      warn(fmt::format("{} is not written: needs the noise of the IMU; expected --noise noise.json", target.name));
      continue;
    }
    out.push_back({&target, input.options.imu_model, fs::path(o.output) / target.file});
    if (target.name == "openvins" && !given(o, "--model")) out.push_back({&target, "rpng", fs::path(o.output) / "kalibr_imu_chain_rpng.yaml"});
  }
  for (const PlannedExport& planned : out) will_write("-o", planned.file), expect_free("-o", planned.file, o.force);
  return out;
}

/// Every target that this calibration and this noise allow; the others are named.
void write_all(const ExportInput& input, const Options& o) {
  if (o.output == "-") throw Error("--to all: writes several files; expected -o FOLDER");
  if (fs::exists(o.output) && !fs::is_directory(o.output)) throw Error(fmt::format("-o {}: is a file; expected a folder", o.output));
  const std::vector<PlannedExport> all = planned_exports(input, o);
  fs::create_directories(o.output);
  std::vector<JsonFields> written;
  std::vector<std::string_view> failed;
  for (const PlannedExport& planned : all) {
    ExportInput of_target = input;
    of_target.options.imu_model = planned.imu_model;
    try {
      written.push_back(write_target(*planned.target, of_target, o, planned.file));
    } catch (const Error& e) {
      warn(fmt::format("{} is not written: {}", planned.target->name, e.what()));
      failed.push_back(planned.target->name);
    }
  }
  if (written.empty()) throw Error(input_name(o.calibration) + ": no target could be written");
  if (o.json) print_json(fields_json({{{"files", written}}}));
  for (const JsonFields& file : written)
    if (!o.json) print(std::get<std::string>(file.fields[1].second.is) + "\n");
  if (!failed.empty())
    throw Unsupported(
        fmt::format("{}: {} of {} targets could not be written: {}", input_name(o.calibration), failed.size(), all.size(), fmt::join(failed, ", ")));
}

void run(const Options& o) {
  check_options(o);
  if (o.target != all_targets) will_write("-o", o.output);
  const Calibration calibration = read_usable(o.calibration, o.allow_undetermined);
  std::optional<ImuNoise> noise;
  if (!o.noise.empty()) noise = read_noise(o.noise);
  ExportInput input{calibration, noise ? &*noise : nullptr, o.choices};
  input.options.axes = o.axes == "mean" ? AxisChoice::mean : AxisChoice::worst;
  if (o.target == all_targets) return write_all(input, o);
  if (o.json && o.output == "-") throw Error("--json: standard output has the export; expected -o FILE");
  const JsonFields written = write_target(export_target(o.target), input, o, o.output);
  if (o.json) print_json(fields_json(written));
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
  names.emplace_back(all_targets);
  help.push_back("all: each of them, into the folder of -o");
  verb.option("CALIBRATION", o->calibration, "calibration.json").required().reads();
  verb.option("--to TARGET", o->target, fmt::format("{}", fmt::join(help, "; "))).required().one_of(names);
  verb.option("-o,--output FILE", o->output, "the file to write; - for standard output; with --to all a folder").show_default();
  const std::vector<std::string_view> noisy{"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter", "json-matrix", "csv"},
      autopilots{"px4", "ardupilot"};
  const auto belongs = [&](const std::string& name, Option option, const std::vector<std::string_view>& targets) {
    o->of_targets.push_back({name, option, targets});
  };
  belongs("--noise", verb.option("--noise FILE", o->noise, "noise.json, from imulab noise: for targets that hold noise").reads(), noisy);
  belongs("--axes",
          verb.option("--axes CHOICE", o->axes, "where a target has one number of noise for three axes: the worst axis, or their mean")
              .one_of({"worst", "mean"})
              .show_default(),
          noisy);
  belongs("--rate",
          verb.option("--rate HZ", o->choices.rate_hz, "samples a second of the stream; without it those of the noise's log").in_range(1e-3, 1e6),
          noisy);
  belongs(
      "--variance-matched",
      verb.flag("--variance-matched", o->choices.variance_matched, "vins: white noise for which the covariance that its code propagates is right"),
      {"vins"});
  belongs("--model", verb.option("--model MODEL", o->choices.imu_model, "openvins: its IMU model").one_of({"kalibr", "rpng"}).show_default(),
          {"openvins"});
  belongs("--instance",
          verb.option("--instance N", o->choices.instance, "px4, ardupilot: which of the autopilot's IMUs, from 0").in_range(0, 3).show_default(),
          autopilots);
  add_allow_undetermined(verb, o->allow_undetermined);
  add_c_header_options(verb, o->c_header);
  verb.flag("--force", o->force, "--to all: replace existing files");
  verb.flag("--json", o->json, "print what was written and what it leaves out as JSON");
  verb.example("imulab export calibration.json --to c-header -o imu_calibration.h");
  verb.example("imulab export calibration.json --to c-header --input-accel g -o imu.h");
  verb.example("imulab export left.json --to c-header --prefix left -o left.h");
  verb.example("imulab export calibration.json --noise noise.json --to kalibr -o imu0.yaml");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
