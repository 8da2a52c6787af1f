#include "imulab/navigation/motion/trajectory.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/error_sources.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/recording/solution.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/result/motion.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/session/mission.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/simulate/simulate_motion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace imulab::command {

namespace {

using namespace motion;

struct Arguments {
  std::string mission, folder;
  std::optional<std::string> unit;
  bool errors = false, json = false;
  std::uint64_t seed = 1;
};

Recording recording_of(const std::vector<Increment>& increments, double rate) {
  Recording r;
  r.name = "recording.csv";
  r.interval_s = 1 / rate;
  r.gyro_increment = r.accel_increment = true;
  r.gyro_unit = "rad/s", r.accel_unit = "m/s^2";
  r.time_ns.reserve(increments.size());
  for (std::size_t i = 0; i < increments.size(); ++i) {
    r.time_ns.push_back(std::llround(1e9 * static_cast<double>(i + 1) / rate));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      r.gyro[axis].push_back(increments[i].angle[static_cast<int>(axis)] * rate);
      r.accel[axis].push_back(increments[i].velocity[static_cast<int>(axis)] * rate);
    }
  }
  return r;
}

/// Three equal columns are written as one.
std::optional<ThermalSource> thermal_source(const Columns3& columns, const std::string& unit, const std::array<const char*, 4>& names) {
  if (columns[0].empty()) return {};
  ThermalSource source;
  source.unit = unit;
  if (columns[0] == columns[1] && columns[0] == columns[2]) {
    source.columns = {names[0]};
  } else {
    source.columns = {names[1], names[2], names[3]};
  }
  return source;
}

/// The session: the recording, the exact start, the truth.
Session session_of(const Mission& mission, const Recording& recording, const NavigationState& start) {
  const EulerAngles angles = euler_angles(start.q_nb.toRotationMatrix());
  Session s;
  s.imu.name = mission.imu;
  s.site.latitude = start.latitude, s.site.longitude = start.longitude, s.site.height = start.height;
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = mission.rate;
  source.time = {.column = "t"};
  const auto triad = [](std::vector<Column> columns, bool increment, const std::string& unit, const char* increment_unit) {
    return TriadSource{.file = {},
                       .columns = std::move(columns),
                       .output = increment ? Output::increment : Output::rate,
                       .unit = increment ? increment_unit : unit,
                       .limits = {}};
  };
  source.gyro = triad({"gx", "gy", "gz"}, recording.gyro_increment, recording.gyro_unit, "rad");
  source.accel = triad({"ax", "ay", "az"}, recording.accel_increment, recording.accel_unit, "m/s");
  const UnitTemperature readings = mission.temperature.value_or(UnitTemperature{});
  source.gyro_temperature = thermal_source(recording.gyro_temperature, readings.gyro.unit, {"tg", "tgx", "tgy", "tgz"});
  source.accel_temperature = thermal_source(recording.accel_temperature, readings.accel.unit, {"ta", "tax", "tay", "taz"});
  s.recordings = {source};
  InitialState& i = s.initial.emplace();
  i.latitude = start.latitude, i.longitude = start.longitude, i.height = start.height;
  i.velocity_enu = {start.velocity.x(), start.velocity.y(), start.velocity.z()};
  i.roll = angles.roll + 0.0, i.pitch = angles.pitch + 0.0, i.heading = angles.heading + 0.0;  // not -0
  s.truth_file = "truth.csv";
  return s;
}

/// The noise of [errors] alone: the coefficients are the IMU's own.
Truth unit_of(const Arguments& a, const MissionFile& file) {
  Truth unit;
  unit.model = read_calibration(*a.unit).model;
  if (!file.errors) return unit;
  const ErrorSources sources = mission_errors(*file.errors, a.mission);
  unit.gyro_noise = sources.gyro_noise;
  unit.accel_noise = sources.accel_noise;
  return unit;
}

/// Of an ideal IMU, of one with the mission's errors, or raw readings of a given one.
Recording recording_on(const Arguments& a, const MissionFile& file, const Trajectory& motion) {
  const double interval = 1 / file.mission.rate;
  if (a.errors) {
    if (!file.errors) throw Error(a.mission + ": --errors: no errors; expected an [errors] table");
    return recording_of(erring_increments(nominal_motion(motion, interval), mission_errors(*file.errors, a.mission), a.seed), file.mission.rate);
  }
  const std::optional<Truth> unit = a.unit ? std::optional(unit_of(a, file)) : std::nullopt;
  Progress progress("samples", motion.duration * file.mission.rate);
  const std::vector<Increment> ideal = ideal_increments(motion, interval, [&](std::uint64_t done) { progress.report(static_cast<double>(done)); });
  return unit ? simulate_motion(ideal, interval, *unit, a.seed, file.mission.temperature) : recording_of(ideal, file.mission.rate);
}

void make(const Arguments& a) {
  const MissionFile file = read_mission(a.mission);
  const Mission& mission = file.mission;
  const Trajectory motion = errors_at(a.mission, [&] { return trajectory_of(mission); });
  NewFolder folder(a.folder);
  const Recording recording = recording_on(a, file, motion);
  write_recording(folder.path() / "recording.csv", recording);
  const Solution solution = truth(motion, 1 / mission.rate, mission.truth_every);
  write_solution(folder.path() / "truth.csv", solution);
  write_session(folder.path() / "session.toml", session_of(mission, recording, solution.states.front()));
  folder.commit();
  if (a.json)
    return print_json(fields_json({{{"folder", a.folder},
                                    {"samples", std::uint64_t{recording.size()}},
                                    {"duration_s", solution.time.back()},
                                    {"rate_hz", mission.rate},
                                    {"truth_rows", std::uint64_t{solution.size()}}}}));
  print(fmt::format("{}\n", a.folder));
  print(fmt::format("  recording.csv  {} samples, {:.10g} s at {:g} Hz\n", recording.size(), solution.time.back(), mission.rate));
  print(fmt::format("  truth.csv      {} rows\n  session.toml\n", solution.size()));
  print(motion_table(recording, solution));
}

}  // namespace

void add_trajectory(Verb app) {
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("trajectory", "Simulate an ideal IMU on a mission: write a session folder with truth.csv");
  verb.option("mission", a->mission, "the mission file: segments, or a recorded track").required().reads();
  verb.option("-o,--output FOLDER", a->folder, "the folder to create").required().creates();
  const Option errors = verb.flag("--errors", a->errors, "give the IMU the errors of the mission's [errors] table");
  verb.option("--unit FILE", a->unit, "truth.json or calibration.json of an IMU: write its raw readings, with the noise of [errors]")
      .reads()
      .excludes(errors);
  verb.option("--seed", a->seed, "random seed of errors and noise; the same seed gives the same result").show_default();
  verb.flag("--json", a->json, "print what was written as JSON");
  verb.example("imulab trajectory flight.toml -o flight");
  verb.does([a] { make(*a); });
}

}  // namespace imulab::command
