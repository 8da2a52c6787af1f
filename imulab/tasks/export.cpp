#include "imulab/tasks/export.hpp"

#include "imulab/error.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/export/extrinsics.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

namespace imulab {
namespace {

constexpr std::string_view c_header_target = "c-header";

// ---- options of c-header

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

void add_c_header_options(Verb& verb, ExportVerbOptions& o) {
  CHeaderArguments& a = o.c_header;
  const std::size_t others = verb.options.size();
  verb.option("--input-accel UNIT", a.accel_unit, "c-header: unit of the firmware's accelerometer readings; absent: as recorded")
      .one_of(rates(Quantity::accel));
  verb.option("--input-gyro UNIT", a.gyro_unit, "c-header: unit of the firmware's gyro readings; absent: as recorded").one_of(rates(Quantity::gyro));
  verb.option("--accel-counts-per-unit N", a.accel_counts_per_unit, "c-header: accelerometer readings are counts, N of them per unit")
      .in_range(1e-9, 1e12);
  verb.option("--gyro-counts-per-unit N", a.gyro_counts_per_unit, "c-header: gyro readings are counts, N of them per unit").in_range(1e-9, 1e12);
  verb.option("--prefix NAME", a.prefix,
              "c-header: prefix of all names, for programs with several IMUs: up to 32 letters, digits and single underscores; absent: imulab");
  verb.option("--body-axes", a.body_axes, "c-header: the readings are along the body axes, not in the recording's columns");
  verb.option("--fixed-point", a.fixed_point, "c-header: add a compensation in 32-bit integers");
  verb.option("--q15", a.q15, "c-header: add a compensation in 16-bit integers");
  verb.option("--accel-range R", a.accel_range,
              "with --fixed-point or --q15: largest accelerometer reading, in counts if the readings are counts; absent: 32768 counts if that is at "
              "least 1.5 g, else 16 g")
      .in_range(1e-9, 1e12);
  verb.option("--gyro-range R", a.gyro_range,
              "with --fixed-point or --q15: largest gyro reading; absent: 32768 counts if that is at least 50 deg/s, else 2000 deg/s")
      .in_range(1e-9, 1e12);
  for (auto row = std::next(verb.options.begin(), static_cast<std::ptrdiff_t>(others)); row != verb.options.end(); ++row)
    o.of_targets.push_back({&*row, {c_header_target}});
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

}  // namespace

Verb& declare(Verb& command, ExportVerbOptions& o) {
  Verb& verb = command.verb("export", "Write a calibration for other programs");
  std::vector<std::string> names, help;
  for (const ExportTarget& target : export_targets()) {
    names.emplace_back(target.name);
    help.push_back(fmt::format("{}: {}", target.name, target.summary));
  }
  std::vector<std::string_view> of_extrinsics;
  for (const ExtrinsicsTarget& target : extrinsics_targets()) {
    of_extrinsics.push_back(target.name);
    if (std::find(names.begin(), names.end(), target.name) == names.end()) names.emplace_back(target.name);
  }
  help.push_back(fmt::format("of extrinsics.json {}", fmt::join(of_extrinsics, ", ")));
  names.emplace_back("all");
  help.push_back("all: each of them, into the folder of -o");
  verb.option("CALIBRATION", o.calibration, "calibration.json, or extrinsics.json; none: export --noise alone").required().reads();
  verb.option("--to TARGET", o.target, fmt::format("{}", fmt::join(help, "; "))).required().one_of(names).called("target");
  verb.option("-o,--output FILE", o.output, "the file to write; - for standard output; with --to all a folder").show_default().of_command();
  const auto belongs_to = [&](const VerbOption& option, const auto& takes) {
    std::vector<std::string_view> takers;
    for (const ExportTarget& target : export_targets())
      if (takes(target)) takers.push_back(target.name);
    o.of_targets.push_back({&option, takers});
  };
  const auto belongs = [&](const VerbOption& option, ExportTarget::Takes taken) {
    belongs_to(option, [&](const ExportTarget& target) { return (target.takes & taken) != 0; });
  };
  const auto needs_noise = [](const ExportTarget& target) { return target.needs_noise; };
  belongs(verb.option("--noise FILE", o.noise,
                      "noise.json of imulab noise, in SI; without it, targets that need noise get the white noise of the calibration's rests")
              .reads(),
          ExportTarget::noise);
  belongs(verb.option("--three-axes CHOICE", o.three_axes, "if the target has one noise figure for three axes: the worst axis, or their mean")
              .one_of({"worst", "mean"})
              .show_default(),
          ExportTarget::noise);
  belongs(verb.option("--stream-rate HZ", o.choices.rate_hz, "sampling rate of the stream; absent: that of the noise log")
              .in_range(1e-3, 1e6)
              .called("rate_hz"),
          ExportTarget::noise);
  belongs_to(verb.option("--bound", o.choices.bound, "write N and K that are at no frequency below what the log permits; from noise --bound"),
             needs_noise);
  belongs_to(verb.option("--inflate X", o.choices.inflate, "multiply noise that is not a bound by this factor; the file says so").in_range(1e-3, 1e4),
             needs_noise);
  belongs(verb.option("--variance-matched", o.choices.variance_matched, "vins: write N sqrt(2 rate), because VINS halves the variance"),
          ExportTarget::variance_matched);
  belongs(verb.option("--model MODEL", o.choices.imu_model, "openvins: its IMU model").one_of({"kalibr", "rpng"}).show_default(),
          ExportTarget::imu_model);
  belongs(
      verb.option("--topic NAME", o.choices.topic, "kalibr, kalibr-imu, openvins: the IMU's topic; absent: that of the calibration's bag, or /imu0"),
      ExportTarget::topic);
  belongs(verb.option("--instance N", o.choices.instance, "px4, ardupilot: which of the autopilot's IMUs, from 0").in_range(0, 3).show_default(),
          ExportTarget::instance);
  allow_undetermined_option(verb, o.allow_undetermined);
  add_c_header_options(verb, o);
  verb.option("--force", o.force, "replace existing files of --to all").of_command();
  json_option(verb, o.json, "print what was written, and what it leaves out, as JSON");
  verb.example("imulab export calibration.json --to c-header -o imu_calibration.h");
  verb.example("imulab export calibration.json --to c-header --input-accel g -o imu.h");
  verb.example("imulab export left.json --to c-header --prefix left -o left.h");
  verb.example("imulab export calibration.json --noise noise.json --to kalibr -o imu0.yaml");
  verb.example("imulab export none --noise noise.json --to kalibr-imu -o imu.yaml");
  return verb;
}

ExportOptions ExportVerbOptions::options() const {
  ExportOptions out = choices;
  out.axes = three_axes == "mean" ? AxisChoice::mean : AxisChoice::worst;
  return out;
}

bool ExportVerbOptions::given(std::string_view name) const {
  return std::any_of(of_targets.begin(), of_targets.end(), [&](const OfTargets& of) { return of.name() == name && of.option->given; });
}

void expect_options_of_target(const ExportVerbOptions& o) {
  for (const ExportVerbOptions::OfTargets& of : o.of_targets)
    if (of.option->given && !o.is_of_all() && std::find(of.targets.begin(), of.targets.end(), o.target) == of.targets.end())
      throw Error(of.targets.front() == c_header_target
                      ? fmt::format("--to {}: has none of the options of c-header; expected --to c-header", o.target)
                      : fmt::format("{}: {} has none; expected one of the targets {}", of.name(), o.target, text::listed(of.targets)));
}

ExportedText exported_text(const ExportTarget& target, const ExportInput& input, const ExportVerbOptions& o, const std::string& sha256) {
  ExportedText out;
  if (target.name == c_header_target) {
    CHeaderOptions options = c_header_options(o.c_header, input.calibration);
    options.calibration_sha256 = sha256;
    out.assumed = assumed_readings(options, input.calibration);
    out.text = c_header(input.calibration, options);
  } else {
    out.text = target.text(input);
  }
  out.left_out = target.left_out(input);
  if (target.warnings != nullptr) out.warnings = target.warnings(input);
  return out;
}

}  // namespace imulab
