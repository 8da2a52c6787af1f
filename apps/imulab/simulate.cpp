#include "imulab/simulate/simulate.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/recording_file.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/io/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string procedure, folder;
  std::optional<std::string> unit;
  std::uint64_t seed = 1;
};

/// The source of a recording as write_recording lays it out: one file, SI units unless counts.
RecordingSource written_source(const RecordingSource& source) {
  RecordingSource written = source;
  written.time = {.column = "t", .unit = "s", .zero_ns = 0};
  const auto triad = [](const TriadSource& from, std::vector<Column> columns, const char* rate_unit, const char* increment_unit) {
    TriadSource to{.file = {}, .columns = std::move(columns), .output = from.output, .unit = from.unit, .limits = from.limits};
    if (from.unit == "count") return to;
    to.unit = from.output == Output::rate ? rate_unit : increment_unit;
    if (to.limits)
      for (double& limit : *to.limits) limit *= si_factor(from.unit);
    return to;
  };
  written.gyro = triad(source.gyro, {"gx", "gy", "gz"}, "rad/s", "rad");
  written.accel = triad(source.accel, {"ax", "ay", "az"}, "m/s^2", "m/s");
  const auto sensors = [](std::optional<ThermalSource>& thermal, const std::string& name) {
    if (!thermal) return;
    std::vector<Column> three{name + "x", name + "y", name + "z"};
    thermal->columns = thermal->columns.size() == 3 ? std::move(three) : std::vector<Column>{name};
  };
  sensors(written.gyro_temperature, "tg");
  sensors(written.accel_temperature, "ta");
  return written;
}

RecordingSource default_source() {
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = 100;
  source.gyro.unit = "rad/s";
  source.accel.unit = "m/s^2";
  return source;
}

void check_file_name(const RecordingSource& source) {
  const fs::path name(source.file);
  if (name.empty() || name.is_absolute() || name.has_parent_path() || name == "session.toml" || name == "truth.json")
    throw Error(fmt::format("[[recording]] file = \"{}\": the name of a file in the session's folder was expected", source.file));
}

/// The session as its user would have it: without the truth, with the limits a sensor's data sheet gives, and without the steps of a hand, which
/// nobody recorded.
Session given_session(Session session, const Truth& truth) {
  session.imu.truth.reset();
  for (RecordingSource& source : session.recordings) {
    const auto limit = [&](TriadSource& triad, double range) {
      const double reading = range * (triad.output == Output::increment ? 1 / source.rate_hz.value_or(100) : 1);
      if (range > 0 && !triad.limits) triad.limits = {-reading, reading};
    };
    limit(source.gyro, truth.gyro_noise.range);
    limit(source.accel, truth.accel_noise.range);
  }
  const bool by_hand = std::all_of(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::none; });
  if (by_hand) session.steps.clear();
  return session;
}

Calibration truth_calibration(const Session& session, const Truth& truth, std::uint64_t seed, const std::string& frame) {
  Calibration c;
  c.imu = session.imu.name;
  c.method = "truth";
  c.software = "imulab " IMULAB_VERSION;
  c.session_file = "session.toml";
  c.frame = frame;
  c.model = truth.model;
  c.quality.verdict = "good";
  c.quality.notes = {fmt::format("seed {}", seed), fmt::format("gravity {} m/s^2", truth.gravity),
                     fmt::format("accelerometer noise {} m/s^2/sqrt(Hz)", truth.accel_noise.N),
                     fmt::format("gyro noise {} rad/s/sqrt(Hz)", truth.gyro_noise.N)};
  if (truth.latitude) c.quality.notes.push_back(fmt::format("latitude {} deg", *truth.latitude / unit::deg));
  return c;
}

void simulate(const Arguments& a) {
  Session procedure = read_session(a.procedure);
  if (procedure.recordings.empty()) procedure.recordings.push_back(default_source());
  for (RecordingSource& source : procedure.recordings) {
    check_file_name(source);
    source = written_source(source);
  }
  std::optional<Calibration> given;
  if (a.unit)
    given = read_calibration(*a.unit);
  else if (procedure.imu.truth)
    given = read_calibration(session_path(procedure, *procedure.imu.truth));
  const Truth truth = draw_truth(procedure, a.seed, given ? std::optional(given->model) : std::nullopt);

  NewFolder folder(a.folder);
  std::string report;
  std::vector<RecordedRigErrors> rig;
  for (const RecordingSource& source : procedure.recordings) {
    rig.push_back({source.file, draw_rig_errors(procedure, source, a.seed)});
    const Recording recording = simulate_recording(procedure, source, truth, a.seed, rig.back().errors);
    write_recording(folder.path() / source.file, recording);
    report += fmt::format("  {:<14} {} samples, {:g} s\n", source.file, recording.size(), recording.time_s(recording.size() - 1));
  }
  const std::string text = session_text(given_session(procedure, truth));
  write_whole(folder.path() / "session.toml", text);
  Calibration calibration = truth_calibration(procedure, truth, a.seed, given ? given->frame : truth.frame);
  calibration.session_sha256 = sha256(text);
  write_whole(folder.path() / "truth.json", truth_text(calibration, rig));
  folder.finish();
  fmt::print("{} (seed {})\n{}  {:<14} what a calibration of this session has to find\n  session.toml\n", a.folder, a.seed, report, "truth.json");
}

}  // namespace

void add_simulate(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* const verb = app.add_subcommand("simulate", "A virtual rig and a virtual IMU: a procedure becomes a session folder with truth.json");
  verb->add_option("procedure", a->procedure, "the procedure or session to carry out")->required();
  verb->add_option("-o,--output", a->folder, "the folder to make")->required();
  verb->add_option("--unit", a->unit, "a truth.json or calibration.json: exactly this unit, in place of the procedure's");
  verb->add_option("--seed", a->seed, "the same seed, the same bits")->capture_default_str();
  verb->callback([a] { simulate(*a); });
}

}  // namespace imulab::command
