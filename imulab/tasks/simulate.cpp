#include "imulab/tasks/simulate.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/written/csv_writer.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/simulate.hpp"
#include "imulab/simulate/effects.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace imulab {
namespace {

namespace fs = std::filesystem;

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

Calibration truth_calibration(const Session& session, const Truth& truth, std::uint64_t seed, BodyFrame frame) {
  Calibration c;
  c.imu = session.imu.name;
  c.method = "truth";
  c.software = software();
  c.session_file = "session.toml";
  c.frame = frame;
  c.model = truth.model;
  c.quality.verdict = Verdict::good;
  c.quality.effects = stated_effects(truth.effects);
  const auto note = [&](const std::string& text) { c.quality.findings.add<Code::simulated>(text); };
  note(fmt::format("seed {}", seed)), note(fmt::format("gravity {} m/s^2", truth.gravity));
  note(fmt::format("accelerometer noise {} m/s^2/sqrt(Hz)", truth.accel_noise.N));
  note(fmt::format("gyro noise {} rad/s/sqrt(Hz)", truth.gyro_noise.N));
  if (truth.latitude) note(fmt::format("latitude {} deg", *truth.latitude / unit::deg));
  return c;
}

/// The procedure with another grade, or with the noise of an analysis; without any grade the IMU is then perfect but for its noise.
void take_grade(ImuDeclaration& imu, const std::string& name) {
  imu.gyro_noise_density = imu.accel_noise_density = std::nullopt;
  imu.gyro_noise = imu.accel_noise = std::nullopt;
  if (name.ends_with(".json"))
    take_noise(imu, name);
  else
    imu.grade = errors_of_option("grade", [&] { return grade(name); }).name;
}

/// An aid is of one recording.
const RecordingSource& only_of(const std::vector<RecordingSource>& sources) {
  if (sources.size() != 1) throw Error(fmt::format("{} recordings with [[aid]]; expected one recording", sources.size()));
  return sources.front();
}

}  // namespace

Simulation simulate_session(Session procedure, const SimulationTask& task) {
  if (task.grade) take_grade(procedure.imu, *task.grade);
  if (procedure.recordings.empty()) procedure.recordings.push_back(default_source());
  for (RecordingSource& source : procedure.recordings) {
    check_file_name(source);
    source = written_source(source);
  }
  std::optional<Calibration> given = task.unit;
  if (!given && procedure.imu.truth) given = read_calibration(session_path(procedure, *procedure.imu.truth));
  if (!given && task.grade && !procedure.imu.grade) given = Calibration{};
  const Truth truth = draw_truth(procedure, task.seed, given ? std::optional(given->model) : std::nullopt);
  Simulation out;
  for (const RecordingSource& source : procedure.recordings) {
    out.rig.push_back({source.file, draw_rig_errors(procedure, source, task.seed)});
    out.recordings.push_back(simulate_recording(procedure, source, truth, task.seed, out.rig.back().errors));
  }
  out.truth = truth_calibration(procedure, truth, task.seed, given ? given->frame : truth.frame);
  const std::vector<Aid> aids = procedure.aids;
  std::optional<motion::Trajectory> moved;
  if (!aids.empty()) moved = trajectory_on_rig(procedure, only_of(procedure.recordings), out.rig.front().errors);
  out.session = given_session(std::move(procedure), truth);
  if (moved) out.aids = simulate_aids(out.session, aids, *moved, task.seed);
  out.truth.session_sha256 = sha256(session_text(out.session));
  return out;
}

void write_simulated(const fs::path& path, const Simulation& simulated) {
  NewFolder folder(path);
  for (std::size_t k = 0; k < simulated.recordings.size(); ++k)
    write_recording(folder.path() / simulated.session.recordings[k].file, simulated.recordings[k]);
  write_aids(folder.path(), simulated.aids);
  write_whole(folder.path() / "session.toml", session_text(simulated.session));
  write_whole(folder.path() / "truth.json", truth_text(simulated.truth, simulated.rig));
  folder.commit();
}

Verb& declare(Verb& command, SimulateOptions& o) {
  Verb& verb = command.verb("simulate", "Simulate a procedure: write a session folder with recordings and truth.json");
  verb.option("procedure", o.procedure, "the procedure or session to carry out").required().reads();
  verb.option("-o,--output FOLDER", o.output, "the folder to create").required().creates().of_command();
  verb.option("--unit FILE", o.unit, "truth.json or calibration.json: simulate this IMU in place of the procedure's");
  verb.option("--grade GRADE", o.grade, "a grade, or noise.json for the noise of a log, in place of the procedure's");
  seed_option(verb, o.seed);
  json_option(verb, o.json, "print what was written as JSON");
  verb.example("imulab simulate procedure.toml -o session --seed 7");
  return verb;
}

AnswerOf<Simulation> simulation_answer(Session procedure, const SimulationTask& task, const std::string& folder) {
  const std::string file = procedure.file;
  const auto work = [&] { return std::make_shared<const Simulation>(simulate_session(std::move(procedure), task)); };
  const auto simulated = file.empty() ? work() : errors_at(file, work);  // a procedure in memory has no file
  if (!folder.empty()) write_simulated(folder, *simulated);
  const auto duration = [](const Recording& r) { return r.time_s(r.size() - 1); };
  return {{.json =
               [=] {
                 std::vector<JsonFields> files;
                 for (const Recording& r : simulated->recordings)
                   files.push_back({{{"file", r.name}, {"samples", std::uint64_t{r.size()}}, {"duration_s", duration(r)}}});
                 return fields_json({{{"folder", folder},
                                      {"seed", task.seed},
                                      {"recordings", files},
                                      {"truth", std::string("truth.json")},
                                      {"aids", aids_json(simulated->aids)}}});
               },
           .table =
               [=](bool) {
                 std::string files;
                 for (const Recording& r : simulated->recordings)
                   files += fmt::format("  {:<14} {} samples, {:g} s\n", one_line(r.name), r.size(), duration(r));
                 return fmt::format("{} (seed {})\n{}{}  {:<14} what a calibration of this session should find\n  session.toml\n", one_line(folder),
                                    task.seed, files, aids_table(simulated->aids), "truth.json");
               }},
          simulated};
}

}  // namespace imulab
