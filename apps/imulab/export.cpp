// imulab export CALIBRATION --to TARGET
#include "imulab/tasks/export.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/export/extrinsics.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/navigate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct ExportedFile {
  std::string file, text;
  JsonFields stated;
};

/// One target's file, after its warnings.
ExportedFile exported(const ExportTarget& target, const ExportInput& input, const ExportVerbOptions& o, const std::string& output) {
  const std::string name = input_name(o.calibration == "none" ? o.noise : o.calibration),
                    place = o.is_of_all() ? fmt::format("{}: {}", name, target.name) : name;
  const bool hashed = target.name == "c-header" && !is_stream(o.calibration);
  ExportedText out = errors_at(name, [&] { return exported_text(target, input, o, hashed ? file_sum(o.calibration).sha256 : ""); });
  for (const std::string& assumed : out.assumed) warn(name + ": " + assumed);
  if (o.is_of_all() && !out.left_out.empty())
    warn(fmt::format("{}: does not hold all of the calibration: the head of {} lists what, and how much", place, output));
  else
    for (const std::string& sentence : out.left_out) warn(fmt::format("{}: not held by {}: {}", place, target.name, sentence));
  if (!o.is_of_all() || !target.needs_noise)  // of all targets the noise is spoken of once
    for (const std::string& warning : out.warnings) warn(place + ": " + warning);
  return {output, std::move(out.text), {{{"target", std::string(target.name)}, {"file", output}, {"left_out", out.left_out}}}};
}

struct PlannedExport {
  const ExportTarget* target;
  std::string imu_model, file;
};

/// Every target but those that need a noise that is not given; OpenVINS with both its models where none is asked for.
std::vector<PlannedExport> planned_exports(const ExportInput& input, const ExportVerbOptions& o) {
  std::vector<PlannedExport> out;
  for (const ExportTarget& target : export_targets()) {
    if (target.needs_noise && input.noise == nullptr && !input.calibration.rest_noise) {
      warn(fmt::format("{} is not written: needs the noise of the IMU; expected --noise noise.json", target.name));
      continue;
    }
    if ((target.takes & ExportTarget::bound) && !(input.noise != nullptr && has_bounds(*input.noise))) {
      warn(fmt::format("{} is not written: needs a bound; expected --noise with a noise.json from noise --bound", target.name));
      continue;
    }
    out.push_back({&target, input.options.imu_model, fs::path(o.output) / target.file});
    if (target.takes & ExportTarget::imu_model && !o.given("--model"))
      out.push_back({&target, "rpng", fs::path(o.output) / "kalibr_imu_chain_rpng.yaml"});
  }
  for (const PlannedExport& planned : out) will_write("-o", planned.file), expect_free("-o", planned.file);
  return out;
}

/// Every target that this calibration and this noise allow; the others are named.
void write_all(const ExportInput& input, const ExportVerbOptions& o, const std::vector<std::string>& warnings) {
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
UsableCalibration calibration_of(const ExportVerbOptions& o) {
  if (o.calibration != "none") return read_usable(o.calibration, o.allow_undetermined);
  if (o.is_of_all() || !export_target(o.target).needs_noise || o.noise.empty())
    throw Error("none: without a calibration there are only targets of noise; expected --noise noise.json and --to kalibr-imu or another of them");
  return {no_calibration(), {}};
}

/// The text of extrinsics.json, which has targets of its own; none for a calibration. Throws Error for options of calibrations.
std::optional<std::string> extrinsics_text_of(const ExportVerbOptions& o) {
  if (o.calibration == "none" || is_stream(o.calibration)) return std::nullopt;
  const MappedFile file(o.calibration, Content::settings);
  if (file.text().find("\"imulab.extrinsics/") == std::string_view::npos) return std::nullopt;
  const SavedResult result = parse_result(file.text(), input_name(o.calibration));
  const auto* const extrinsics = std::get_if<Extrinsics>(&result);
  if (extrinsics == nullptr) return std::nullopt;
  for (const ExportVerbOptions::OfTargets& of : o.of_targets)
    if (of.option->given) throw Error(fmt::format("{}: belongs to calibrations; expected extrinsics alone", of.name()));
  return exported_extrinsics(*extrinsics, o.target);
}

void run(const ExportVerbOptions& o) {
  expect_options_of_target(o);
  if (const auto text = extrinsics_text_of(o)) {
    will_write("-o", o.output);
    write_whole(o.output, *text);
    if (o.json) print_json({{{"target", o.target}, {"file", o.output}}}, {Verdict::none, "written: " + o.output});
    return;
  }
  if (!o.is_of_all()) will_write("-o", o.output);
  const auto [calibration, warnings] = calibration_of(o);
  std::optional<ImuNoise> noise;
  if (!o.noise.empty()) noise = read_noise(o.noise);
  const ExportInput input{calibration, noise ? &*noise : nullptr, o.options()};
  if (o.is_of_all()) return write_all(input, o, warnings);
  if (o.json && o.output == "-") throw Error("--json: standard output has the export; expected -o FILE");
  const ExportedFile file = exported(export_target(o.target), input, o, o.output);
  write_whole(o.output, file.text);
  if (o.json) print_json(file.stated, {Verdict::none, "written: " + o.output}, warnings);
}

}  // namespace

void add_export(Verb& app) {
  const auto o = std::make_shared<ExportVerbOptions>();
  declare(app, *o).does = [o] { run(*o); };
}

}  // namespace imulab::command
