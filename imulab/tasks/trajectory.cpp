#include "imulab/tasks/trajectory.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/solution/solution.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/results/navigation.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

using namespace motion;

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

ErrorSources mission_errors(const MissionFile& file, const std::string& mission, std::vector<std::string>& warnings) {
  ErrorSourcesReading reading = read_error_sources(*file.errors, mission);
  if (const auto& name = file.errors->calibration) {
    const std::filesystem::path path = std::filesystem::path(mission).parent_path() / *name;
    for (std::string& doubt : doubt_about(read_calibration(path), path.string())) reading.warnings.push_back(std::move(doubt));
  }
  warnings.insert(warnings.end(), reading.warnings.begin(), reading.warnings.end());
  return std::move(reading.sources);
}

/// The noise of [errors] alone: the coefficients are the IMU's own.
Truth unit_of(const MissionFile& file, const TrajectoryTask& task, std::vector<std::string>& warnings) {
  Truth unit;
  unit.model = task.unit->model;
  if (!file.errors) return unit;
  const ErrorSources sources = mission_errors(file, task.mission, warnings);
  unit.gyro_noise = sources.gyro_noise;
  unit.accel_noise = sources.accel_noise;
  return unit;
}

/// The recording of an ideal IMU or of one with the mission's errors, or the raw readings of a given IMU.
Recording recording_on(const MissionFile& file, const TrajectoryTask& task, const Trajectory& motion, std::vector<std::string>& warnings) {
  const double interval = 1 / file.mission.rate;
  if (task.errors) {
    if (!file.errors) throw Error(task.mission + ": has no errors; expected an [errors] table");
    return recording_of(erring_increments(nominal_motion(motion, interval), mission_errors(file, task.mission, warnings), task.seed),
                        file.mission.rate);
  }
  const std::optional<Truth> unit = task.unit ? std::optional(unit_of(file, task, warnings)) : std::nullopt;
  const double samples = motion.duration * file.mission.rate;
  const std::vector<Increment> ideal = ideal_increments(motion, interval, [&](std::uint64_t done) {
    if (task.progress) task.progress(static_cast<double>(done) / samples);
  });
  return unit ? simulate_motion(ideal, interval, *unit, task.seed, file.mission.temperature) : recording_of(ideal, file.mission.rate);
}

/// The vertical channel of [errors], and the barometer that it uses: an ideal one, or with the mission's errors where the readings have them.
void add_vertical_channel(const MissionFile& file, const TrajectoryTask& task, const Trajectory& motion, FlownMission& out) {
  if (!file.errors || file.errors->vertical == VerticalChannel::free) return;
  out.session.vertical = file.errors->vertical;
  if (file.errors->vertical == VerticalChannel::fixed) return;
  constexpr double readings_per_s = 10;  // heights between them are linear
  const auto every = static_cast<std::size_t>(std::max(1.0, std::round(file.mission.rate / readings_per_s)));
  const BarometerErrors errors = task.errors || task.unit ? file.errors->barometer : BarometerErrors{};
  out.heights = erring_heights(nominal_motion(motion, 1 / file.mission.rate), errors, task.seed, every);
  out.session.barometer_file = "barometer.csv";
}

std::string heights_csv(const HeightRecord& heights) {
  std::string text = "t,height_m\n";
  for (std::size_t i = 0; i < heights.time.size(); ++i) text += fmt::format("{:.9f},{:.4f}\n", heights.time[i], heights.height[i]);
  return text;
}

}  // namespace

ImuDeclaration declared_imu(const MissionFile& file, const std::string& mission, std::vector<std::string>& warnings) {
  ImuDeclaration imu{.name = file.mission.imu};
  if (!file.errors) return imu;
  imu.grade = file.errors->system ? "navigation" : file.errors->grade;
  ErrorSources sources = mission_errors(file, mission, warnings);
  const auto declare_noise = [](NoiseModel& noise, std::optional<double>& density, std::optional<NoiseModel>& terms) {
    if (!(noise.N > 0)) return;  // none is declared: the grade's
    density = std::exchange(noise.N, 0), terms = noise;
  };
  declare_noise(sources.gyro_noise, imu.gyro_noise_density, imu.gyro_noise);
  declare_noise(sources.accel_noise, imu.accel_noise_density, imu.accel_noise);
  return imu;
}

FlownMission fly(const MissionFile& file, const TrajectoryTask& task) {
  const Trajectory motion = errors_at(task.mission, [&] { return trajectory_of(file.mission); });
  FlownMission out;
  out.recording = recording_on(file, task, motion, out.warnings);
  out.truth = truth(motion, 1 / file.mission.rate, file.mission.truth_every);
  out.session = session_of(file.mission, out.recording, out.truth.states.front());
  add_vertical_channel(file, task, motion, out);
  if (!file.mission.aids.empty() && (task.errors || task.unit)) {
    std::vector<std::string> told;  // already
    out.session.imu = declared_imu(file, task.mission, told);
  }
  if (out.session.imu.name.empty()) out.session.imu.name = task.errors || task.unit ? "simulated IMU" : "ideal IMU";
  out.aids = simulate_aids(out.session, file.mission.aids, motion, task.seed);
  return out;
}

void write_flown(const std::filesystem::path& path, const FlownMission& flown) {
  NewFolder folder(path);
  write_recording(folder.path() / "recording.csv", flown.recording);
  write_solution(folder.path() / "truth.csv", flown.truth);
  if (flown.heights) write_whole(folder.path() / "barometer.csv", heights_csv(*flown.heights));
  write_aids(folder.path(), flown.aids);
  write_session(folder.path() / "session.toml", flown.session);
  folder.commit();
}

Verb& declare(Verb& command, TrajectoryOptions& o) {
  Verb& verb = command.verb("trajectory", "Simulate an ideal IMU on a mission: write a session folder with truth.csv");
  verb.option("mission", o.mission, "the mission file: segments, or a recorded track").required().reads();
  verb.option("-o,--output FOLDER", o.output, "the folder to create").required().creates().of_command();
  VerbOption& errors = verb.option("--errors", o.errors, "draw the errors of the mission's [errors], and give them to the IMU");
  verb.option("--unit FILE", o.unit, "truth.json or calibration.json: write the raw readings of this IMU, with the noise of [errors]")
      .reads()
      .excludes(errors);
  seed_option(verb, o.seed, "random seed of errors and noise; the same seed gives the same result");
  json_option(verb, o.json, "print what was written as JSON");
  verb.example("imulab trajectory flight.toml -o flight");
  return verb;
}

AnswerOf<FlownMission> flight_answer(const MissionFile& file, const TrajectoryTask& task, const std::string& folder) {
  const auto flown = std::make_shared<const FlownMission>(fly(file, task));
  if (!folder.empty()) write_flown(folder, *flown);
  const double end = flown->truth.time.back(), rate = file.mission.rate;
  return {{.json =
               [=] {
                 return fields_json({{{"folder", folder},
                                      {"samples", std::uint64_t{flown->recording.size()}},
                                      {"duration_s", end},
                                      {"rate_hz", rate},
                                      {"truth_rows", std::uint64_t{flown->truth.size()}},
                                      {"vertical", flown->session.vertical ? JsonValue(to_string(*flown->session.vertical)) : JsonValue()},
                                      {"aids", aids_json(flown->aids)}}});
               },
           .table =
               [=](bool) {
                 const std::string heights = flown->heights ? fmt::format("  barometer.csv  {} heights\n", flown->heights->time.size()) : "";
                 return fmt::format("{}\n  recording.csv  {} samples, {:.10g} s at {:g} Hz\n  truth.csv      {} rows\n{}{}  session.toml\n{}",
                                    one_line(folder), flown->recording.size(), end, rate, flown->truth.size(), heights, aids_table(flown->aids),
                                    motion_table(flown->recording, flown->truth));
               },
           .warnings = flown->warnings},
          flown};
}

}  // namespace imulab
