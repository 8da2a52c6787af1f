#include "imulab/navigation/trajectory.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/error_sources.hpp"
#include "imulab/analysis/error_monte_carlo.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/mission_file.hpp"
#include "imulab/io/recording_file.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/io/solution_file.hpp"
#include "imulab/io/terminal.hpp"
#include "imulab/simulate/simulate_motion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace imulab::command {

namespace {

struct Arguments {
  std::string mission, folder;
  std::optional<std::string> unit;
  bool errors = false;
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
  source.time = {.column = "t", .unit = "s", .zero_ns = 0};
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

void print_summary(const Recording& recording, const Solution& truth) {
  double way = 0, fastest = 0, bank = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double speed = truth.states[i].velocity.norm();
    if (i > 0) way += (truth.time[i] - truth.time[i - 1]) * (speed + truth.states[i - 1].velocity.norm()) / 2;
    fastest = std::max(fastest, speed);
    bank = std::max(bank, std::abs(euler_angles(truth.states[i].q_nb.toRotationMatrix()).roll));
  }
  const auto largest = [](const std::vector<double>& column) {
    return std::abs(*std::max_element(column.begin(), column.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  };
  const auto largest_of = [&](const Columns3& c, double unit) {
    return fmt::format("{:.4g}, {:.4g}, {:.4g}", largest(c[0]) / unit, largest(c[1]) / unit, largest(c[2]) / unit);
  };
  fmt::print("  distance       {:.6g} km, at most {:.5g} m/s\n", way / 1000, fastest);
  fmt::print("  largest bank   {:.4g} deg\n", bank / unit::deg);
  if (recording.gyro_unit != "rad/s" || recording.accel_unit != "m/s^2") return;  // counts
  fmt::print("  largest rate   {} deg/s about x, y, z\n", largest_of(recording.gyro, unit::deg));
  fmt::print("  largest force  {} m/s^2 along x, y, z\n", largest_of(recording.accel, 1));
}

/// The noise of [errors] alone: the coefficients are the unit's own.
Truth unit_of(const Arguments& a, const MissionFile& file) {
  Truth unit;
  unit.model = read_calibration(*a.unit).model;
  if (!file.errors) return unit;
  const ErrorSources sources = read_error_sources(*file.errors, a.mission);
  unit.gyro_noise = sources.gyro_noise;
  unit.accel_noise = sources.accel_noise;
  return unit;
}

/// Of an ideal unit, of one with the mission's errors, or raw readings of a given one.
Recording recording_on(const Arguments& a, const MissionFile& file, const Trajectory& motion) {
  const double interval = 1 / file.mission.rate;
  if (a.errors) {
    if (!file.errors) throw Error(a.mission + ": --errors: an [errors] table was expected");
    return recording_of(erring_increments(nominal_motion(motion, interval), read_error_sources(*file.errors, a.mission), a.seed), file.mission.rate);
  }
  const std::optional<Truth> unit = a.unit ? std::optional(unit_of(a, file)) : std::nullopt;
  Progress progress("samples", static_cast<std::uint64_t>(motion.duration * file.mission.rate));
  const std::vector<Increment> ideal = ideal_increments(motion, interval, [&](std::uint64_t done) { progress.report(done); });
  return unit ? simulate_motion(ideal, interval, *unit, a.seed, file.mission.temperature) : recording_of(ideal, file.mission.rate);
}

void make(const Arguments& a) {
  const MissionFile file = read_mission(a.mission);
  const Mission& mission = file.mission;
  const Trajectory motion = [&] {
    try {
      return trajectory_of(mission);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", a.mission, e.what()));
    }
  }();
  NewFolder folder(a.folder);
  const Recording recording = recording_on(a, file, motion);
  write_recording(folder.path() / "recording.csv", recording);
  const Solution solution = truth(motion, 1 / mission.rate, mission.truth_every);
  write_solution(folder.path() / "truth.csv", solution);
  write_whole(folder.path() / "session.toml", session_text(session_of(mission, recording, solution.states.front())));
  folder.finish();
  fmt::print("{}\n", a.folder);
  fmt::print("  recording.csv  {} samples, {:.10g} s at {:g} Hz\n", recording.size(), solution.time.back(), mission.rate);
  fmt::print("  truth.csv      {} rows\n  session.toml\n", solution.size());
  print_summary(recording, solution);
}

}  // namespace

void add_trajectory(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* const verb = app.add_subcommand("trajectory", "A motion and the ideal IMU on it: a mission becomes a session folder with truth.csv");
  verb->add_option("mission", a->mission, "the mission file: segments, or a recorded track")->required();
  verb->add_option("-o,--output", a->folder, "the folder to make")->required();
  CLI::Option* const errors = verb->add_flag("--errors", a->errors, "the unit has the errors that the mission's [errors] table specifies, instead of none");
  verb->add_option("--unit", a->unit, "a truth.json or calibration.json: its raw readings, with the noise of [errors]")->excludes(errors);
  verb->add_option("--seed", a->seed, "of errors and noise: the same seed, the same bits")->capture_default_str();
  verb->callback([a] { make(*a); });
}

}  // namespace imulab::command
