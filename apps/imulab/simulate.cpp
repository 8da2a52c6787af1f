#include "imulab/simulate/simulate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/model/grade.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string procedure, folder;
  std::optional<std::string> unit, grade;
  std::uint64_t seed = 1;
  bool json = false;
};

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
    throw Error(fmt::format("[[recording]] file = \"{}\"; expected the name of a file in the session's folder", source.file));
}

/// The session as a user would have it: without the truth, with the limits of a data sheet, and without the steps of a hand, which nobody
/// recorded.
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
  c.software = software();
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

/// The procedure with another grade, or with the noise of an analysis; without any grade the IMU is then perfect but for its noise.
Session procedure_of(const Arguments& a) {
  Session procedure = session_at(a.procedure);
  if (!a.grade) return procedure;
  ImuDeclaration& imu = procedure.imu;
  imu.gyro_noise_density = imu.accel_noise_density = std::nullopt;
  imu.gyro_noise = imu.accel_noise = std::nullopt;
  if (a.grade->ends_with(".json"))
    take_noise(imu, *a.grade);
  else
    imu.grade = grade(*a.grade).name;
  return procedure;
}

void simulate(const Arguments& a) {
  Session procedure = procedure_of(a);
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
  else if (a.grade && !procedure.imu.grade)
    given = Calibration{};
  const Truth truth = draw_truth(procedure, a.seed, given ? std::optional(given->model) : std::nullopt);

  NewFolder folder(a.folder);
  std::string report;
  std::vector<JsonFields> files;
  std::vector<RecordedRigErrors> rig;
  for (const RecordingSource& source : procedure.recordings) {
    rig.push_back({source.file, draw_rig_errors(procedure, source, a.seed)});
    const Recording recording = errors_at(procedure.file, [&] { return simulate_recording(procedure, source, truth, a.seed, rig.back().errors); });
    write_recording(folder.path() / source.file, recording);
    const double duration = recording.time_s(recording.size() - 1);
    report += fmt::format("  {:<14} {} samples, {:g} s\n", source.file, recording.size(), duration);
    files.push_back({{{"file", source.file}, {"samples", std::uint64_t{recording.size()}}, {"duration_s", duration}}});
  }
  const std::string text = session_text(given_session(procedure, truth));
  write_whole(folder.path() / "session.toml", text);
  Calibration calibration = truth_calibration(procedure, truth, a.seed, given ? given->frame : truth.frame);
  calibration.session_sha256 = sha256(text);
  write_whole(folder.path() / "truth.json", truth_text(calibration, rig));
  folder.commit();
  if (a.json) return print_json(fields_json({{{"folder", a.folder}, {"seed", a.seed}, {"recordings", files}, {"truth", std::string("truth.json")}}}));
  print(fmt::format("{} (seed {})\n{}  {:<14} what a calibration of this session has to find\n  session.toml\n", a.folder, a.seed, report,
                    "truth.json"));
}

}  // namespace

void add_simulate(Verb app) {
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("simulate", "Simulate a procedure: write a session folder with recordings and truth.json");
  verb.option("procedure", a->procedure, "the procedure or session to carry out").required().reads();
  verb.option("-o,--output FOLDER", a->folder, "the folder to create").required().creates();
  verb.option("--unit FILE", a->unit, "truth.json or calibration.json of the IMU to simulate, in place of the procedure's");
  verb.option("--grade GRADE", a->grade, "a grade by its name, or noise.json: the noise of a log at rest, in place of the procedure's");
  verb.option("--seed", a->seed, "random seed; the same seed gives the same result").show_default();
  verb.flag("--json", a->json, "print what was written as JSON");
  verb.example("imulab simulate procedure.toml -o session --seed 7");
  verb.does([a] { simulate(*a); });
}

}  // namespace imulab::command
