// imulab export CALIBRATION --to TARGET
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/tasks/navigate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

// ---- options of c-header

struct CHeaderArguments {
  std::optional<std::string> accel_unit, gyro_unit;
  std::optional<double> accel_counts_per_unit, gyro_counts_per_unit, accel_range, gyro_range;
  bool body_axes = false, fixed_point = false, q15 = false;
  std::optional<std::string> prefix;

  bool given() const {
    return accel_unit || gyro_unit || accel_counts_per_unit || gyro_counts_per_unit || accel_range || gyro_range || body_axes || fixed_point || q15 ||
           prefix;
  }
};

std::vector<std::string> rates(Quantity quantity) {
  const std::vector<std::string_view> names = unit_names(quantity, false);
  return {names.begin(), names.end()};
}

/// A triad's readings: as recorded, or the model's own, changed by the arguments.
std::optional<RecordedAs> readings(const std::optional<std::string>& unit, const std::optional<double>& counts, bool body_axes,
                                   const std::optional<RecordedAs>& recorded, const std::string& raw) {
  if (!unit && !counts && !body_axes) return std::nullopt;
  RecordedAs as = recorded.value_or(RecordedAs{raw});
  if (unit) as.unit = *unit, as.counts_per_unit = 1, as.interval_s = 0;
  if (counts) as.counts_per_unit = *counts;
  if (body_axes) as.axes = RecordedAs{}.axes;
  return as;
}

void add_c_header_options(Verb& verb, CHeaderArguments& a) {
  verb.option("--input-accel UNIT", a.accel_unit, "c-header: unit of the firmware's accelerometer readings; absent: as recorded")
      .one_of(rates(Quantity::accel));
  verb.option("--input-gyro UNIT", a.gyro_unit, "c-header: unit of its gyro readings; absent: as recorded").one_of(rates(Quantity::gyro));
  verb.option("--accel-counts-per-unit N", a.accel_counts_per_unit, "c-header: the readings are counts, so many to one unit").in_range(1e-9, 1e12);
  verb.option("--gyro-counts-per-unit N", a.gyro_counts_per_unit, "c-header: the same of the gyros").in_range(1e-9, 1e12);
  verb.option("--prefix NAME", a.prefix, "c-header: with which its names begin, for programs with several IMUs; absent: imulab");
  verb.option("--body-axes", a.body_axes, "c-header: the readings are along the body axes, not in the recording's columns");
  verb.option("--fixed-point", a.fixed_point, "c-header: also a compensation in integers of 32 bits");
  verb.option("--q15", a.q15, "c-header: also a compensation in integers of 16 bits");
  verb.option("--accel-range R", a.accel_range,
              "--fixed-point, --q15: largest reading of the firmware, counts where it has them; absent: 32768 counts, or 16 g")
      .in_range(1e-9, 1e12);
  verb.option("--gyro-range R", a.gyro_range, "--fixed-point, --q15: the same of the gyros; absent: 32768 counts, or 2000 deg/s")
      .in_range(1e-9, 1e12);
}

/// With the calibration's description of its recording where the arguments are silent. Throws Error where they are unusable.
CHeaderOptions c_header_options(const CHeaderArguments& a, const Calibration& c) {
  const auto or_si = [](const std::string& raw, const char* si) { return raw.empty() ? std::string(si) : raw; };
  CHeaderOptions out;
  out.accel = readings(a.accel_unit, a.accel_counts_per_unit, a.body_axes, c.recorded_accel, or_si(c.model.accel.raw_unit, "m/s^2"));
  out.gyro = readings(a.gyro_unit, a.gyro_counts_per_unit, a.body_axes, c.recorded_gyro, or_si(c.model.gyro.raw_unit, "rad/s"));
  out.fixed_point = a.fixed_point, out.q15 = a.q15;
  if (a.prefix) errors_at("--prefix", [&] { firmware::expect_prefix(*a.prefix); }), out.prefix = *a.prefix;
  for (const auto& [option, from, to] :
       {std::tuple("--accel-range", a.accel_range, &out.accel_range), {"--gyro-range", a.gyro_range, &out.gyro_range}}) {
    if (!from) continue;
    if (!a.fixed_point && !a.q15) throw Error(std::string(option) + ": is of --fixed-point and --q15; expected one of these flags as well");
    *to = *from;
  }
  return out;
}

/// The assumptions about readings that neither the options nor the calibration describe, and are not counts.
std::vector<std::string> assumed_readings(const CHeaderOptions& options, const Calibration& c) {
  std::vector<std::string> out;
  const auto add = [&out](bool known, const std::string& raw, const std::string& name, const std::string& unit, const std::string& option) {
    if (!known && raw != "count")
      out.push_back(fmt::format("does not say how the {} were recorded: the header takes {}; {} gives another unit", name, unit, option));
  };
  add(options.accel || c.recorded_accel, c.model.accel.raw_unit, "accelerometers", "m/s^2", "--input-accel");
  add(options.gyro || c.recorded_gyro, c.model.gyro.raw_unit, "gyros", "rad/s", "--input-gyro");
  return out;
}

// ---- all targets

constexpr const char* all_targets = "all";

/// An option that only some targets have.
struct TargetOption {
  const VerbOption* option;
  std::vector<std::string_view> targets;
  const std::string& name() const { return option->flags.back(); }
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
    if (of.option->given && o.target != all_targets && std::find(of.targets.begin(), of.targets.end(), o.target) == of.targets.end())
      throw Error(fmt::format("{}: {} has none; expected one of the targets {}", of.name(), o.target, text::listed(of.targets)));
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

struct ExportedFile {
  std::string file, text;
  JsonFields stated;
};

/// One target's file, after its warnings.
ExportedFile exported(const ExportTarget& target, const ExportInput& input, const Options& o, const std::string& output) {
  std::string text = errors_at(input_name(o.calibration), [&] { return text_of(target, input, o); });
  const std::vector<std::string> lost = target.left_out(input);
  const std::string place = o.target == all_targets ? fmt::format("{}: {}", input_name(o.calibration), target.name) : input_name(o.calibration);
  if (o.target == all_targets && !lost.empty())
    warn(fmt::format("{}: does not hold all of the calibration: the head of {} lists what, and how much", place, output));
  else
    for (const std::string& sentence : lost) warn(fmt::format("{}: not held by {}: {}", place, target.name, sentence));
  if (target.warnings != nullptr && (o.target != all_targets || !target.needs_noise))  // of all targets the noise is spoken of once
    for (const std::string& warning : target.warnings(input)) warn(place + ": " + warning);
  return {output, std::move(text), {{{"target", std::string(target.name)}, {"file", output}, {"left_out", lost}}}};
}

bool given(const Options& o, std::string_view name) {
  return std::any_of(o.of_targets.begin(), o.of_targets.end(), [&](const TargetOption& of) { return of.name() == name && of.option->given; });
}

struct PlannedExport {
  const ExportTarget* target;
  std::string imu_model, file;
};

/// Every target but those that need a noise that is not given; OpenVINS with both its models where none is asked for.
std::vector<PlannedExport> planned_exports(const ExportInput& input, const Options& o) {
  std::vector<PlannedExport> out;
  for (const ExportTarget& target : export_targets()) {
    if (target.needs_noise && input.noise == nullptr && !input.calibration.rest_noise) {
      warn(fmt::format("{} is not written: needs the noise of the IMU; expected --noise noise.json", target.name));
      continue;
    }
    out.push_back({&target, input.options.imu_model, fs::path(o.output) / target.file});
    if (target.takes & ExportTarget::imu_model && !given(o, "--model"))
      out.push_back({&target, "rpng", fs::path(o.output) / "kalibr_imu_chain_rpng.yaml"});
  }
  for (const PlannedExport& planned : out) will_write("-o", planned.file), expect_free("-o", planned.file, o.force);
  return out;
}

/// Every target that this calibration and this noise allow; the others are named.
void write_all(const ExportInput& input, const Options& o, const std::vector<std::string>& warnings) {
  if (o.output == "-") throw Error("--to all: writes several files; expected -o FOLDER");
  if (fs::exists(o.output) && !fs::is_directory(o.output)) throw Error(fmt::format("-o {}: is a file; expected a folder", o.output));
  const std::vector<PlannedExport> all = planned_exports(input, o);
  for (const std::string& warning : export_target("kalibr").warnings(input)) warn(input_name(o.calibration) + ": " + warning);
  std::vector<ExportedFile> files;
  std::vector<std::string_view> failed;
  std::string said;  // a target of two models that cannot be written for one reason says it once
  for (const PlannedExport& planned : all) {
    ExportInput of_target = input;
    of_target.options.imu_model = planned.imu_model;
    try {
      files.push_back(exported(*planned.target, of_target, o, planned.file));
    } catch (const Error& e) {
      const std::string why = fmt::format("{} is not written: {}", planned.target->name, e.what());
      if (why == said) continue;
      warn(said = why);
      failed.push_back(planned.target->name);
    }
  }
  if (files.empty()) throw Error(input_name(o.calibration) + ": no target could be written");
  NewFolder folder(o.output, NewFolder::Existing::add);
  for (const ExportedFile& file : files) write_whole(folder.path() / fs::path(file.file).filename(), file.text);
  folder.commit();
  std::vector<JsonFields> written;
  for (const ExportedFile& file : files) written.push_back(file.stated);
  if (o.json) print_json({{{"files", written}}}, {Verdict::none, "written: " + o.output}, warnings);
  for (const ExportedFile& file : files)
    if (!o.json) print(one_line(file.file) + "\n");
  std::set<const ExportTarget*> targets;  // of several models each once
  for (const PlannedExport& planned : all) targets.insert(planned.target);
  if (!failed.empty())
    throw Unsupported(fmt::format("{}: {} of {} targets could not be written: {}", input_name(o.calibration), failed.size(), targets.size(),
                                  fmt::join(failed, ", ")));
}

/// The word none: an IMU without a calibration, for targets that hold its noise.
UsableCalibration calibration_of(const Options& o) {
  if (o.calibration != "none") return read_usable(o.calibration, o.allow_undetermined);
  if (o.target == all_targets || !export_target(o.target).needs_noise || o.noise.empty())
    throw Error("none: without a calibration there are only targets of noise; expected --noise noise.json and --to kalibr-imu or another of them");
  return {no_calibration(), {}};
}

void run(const Options& o) {
  check_options(o);
  if (o.target != all_targets) will_write("-o", o.output);
  const auto [calibration, warnings] = calibration_of(o);
  std::optional<ImuNoise> noise;
  if (!o.noise.empty()) noise = read_noise(o.noise);
  ExportInput input{calibration, noise ? &*noise : nullptr, o.choices};
  input.options.axes = o.axes == "mean" ? AxisChoice::mean : AxisChoice::worst;
  if (o.target == all_targets) return write_all(input, o, warnings);
  if (o.json && o.output == "-") throw Error("--json: standard output has the export; expected -o FILE");
  const ExportedFile file = exported(export_target(o.target), input, o, o.output);
  write_whole(o.output, file.text);
  if (o.json) print_json(file.stated, {Verdict::none, "written: " + o.output}, warnings);
}

}  // namespace

void add_export(Verb& app) {
  const auto o = std::make_shared<Options>();
  Verb& verb = app.verb("export", "Write a calibration for other programs");
  std::vector<std::string> names, help;
  for (const ExportTarget& target : export_targets()) {
    names.emplace_back(target.name);
    help.push_back(fmt::format("{}: {}", target.name, target.summary));
  }
  names.emplace_back(all_targets);
  help.push_back("all: each of them, into the folder of -o");
  verb.option("CALIBRATION", o->calibration, "calibration.json; none: of --noise alone").required().reads();
  verb.option("--to TARGET", o->target, fmt::format("{}", fmt::join(help, "; "))).required().one_of(names);
  verb.option("-o,--output FILE", o->output, "the file to write; - for standard output; with --to all a folder").show_default();
  const auto belongs = [&](const VerbOption& option, ExportTarget::Takes taken) {
    std::vector<std::string_view> takers;
    for (const ExportTarget& target : export_targets())
      if (target.takes & taken) takers.push_back(target.name);
    o->of_targets.push_back({&option, takers});
  };
  belongs(verb.option("--noise FILE", o->noise,
                      "noise.json, from imulab noise: for targets that hold noise; without it those that need it have the white noise of the "
                      "calibration's rests")
              .reads(),
          ExportTarget::noise);
  belongs(verb.option("--axes CHOICE", o->axes, "where a target has one number of noise for three axes: the worst axis, or their mean")
              .one_of({"worst", "mean"})
              .show_default(),
          ExportTarget::noise);
  belongs(verb.option("--rate HZ", o->choices.rate_hz, "samples a second of the stream; without it those of the noise's log").in_range(1e-3, 1e6),
          ExportTarget::noise);
  belongs(
      verb.option("--variance-matched", o->choices.variance_matched, "vins: white noise for which the covariance that its code propagates is right"),
      ExportTarget::variance_matched);
  belongs(verb.option("--model MODEL", o->choices.imu_model, "openvins: its IMU model").one_of({"kalibr", "rpng"}).show_default(),
          ExportTarget::imu_model);
  belongs(
      verb.option("--topic NAME", o->choices.topic, "kalibr, kalibr-imu, openvins: the IMU's topic; absent: that of the calibration's bag, or /imu0"),
      ExportTarget::topic);
  belongs(verb.option("--instance N", o->choices.instance, "px4, ardupilot: which of the autopilot's IMUs, from 0").in_range(0, 3).show_default(),
          ExportTarget::instance);
  allow_undetermined_option(verb, o->allow_undetermined);
  add_c_header_options(verb, o->c_header);
  verb.option("--force", o->force, "--to all: replace existing files");
  json_option(verb, o->json, "print what was written and what it leaves out as JSON");
  verb.example("imulab export calibration.json --to c-header -o imu_calibration.h");
  verb.example("imulab export calibration.json --to c-header --input-accel g -o imu.h");
  verb.example("imulab export left.json --to c-header --prefix left -o left.h");
  verb.example("imulab export calibration.json --noise noise.json --to kalibr -o imu0.yaml");
  verb.example("imulab export none --noise noise.json --to kalibr-imu -o imu.yaml");
  verb.does = [o] { run(*o); };
}

}  // namespace imulab::command
