#include "imulab/simulate.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/core/random.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/published_grades.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/recording.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/temperature.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate/effects.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace imulab {

namespace {

using namespace simulate;

const std::set<std::string, std::less<>> si_units{"rad/s", "rad", "m/s^2", "m/s"};

/// The limits of the readings, ascending; none if both are infinite.
struct Limits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool any() const { return std::isfinite(low) || std::isfinite(high); }
};

Limits limits_of(const NoiseModel& noise, const TriadSource& triad, double interval_s) {
  Limits limits;
  if (noise.range > 0) limits = {-noise.range, noise.range};
  if (triad.limits) {
    if (triad.unit != "count" && si_units.find(triad.unit) == si_units.end())
      throw Error(fmt::format("limits in \"{}\"; expected counts or SI", triad.unit));
    const double interval = triad.output == Output::increment ? interval_s : 1;  // a reading is a mean here
    limits = {std::max(limits.low, (*triad.limits)[0] / interval), std::min(limits.high, (*triad.limits)[1] / interval)};
  }
  return limits;
}

/// Whole steps of the resolution, inside the limits.
void read_out(double resolution, const Limits& limits, std::span<double> out) {
  if (resolution > 0)
    for (double& x : out) x = std::nearbyint(x / resolution) * resolution;
  if (limits.any())
    for (double& x : out) x = std::clamp(x, limits.low, limits.high);
}

std::span<double> column(Recording& recording, std::size_t axis) { return axis < 3 ? recording.gyro[axis] : recording.accel[axis - 3]; }

/// Six axes' noise, gyros first.
std::vector<AxisNoise> noise_of(const Truth& truth, const RecordingSource& source, double interval_s, std::uint64_t seed) {
  std::vector<AxisNoise> noise;
  for (const char* triad : {"gyro", "accel"})
    for (const char axis : {'x', 'y', 'z'})
      noise.emplace_back(triad[0] == 'g' ? truth.gyro_noise : truth.accel_noise, interval_s, seed,
                         fmt::format("{}.{} noise of {}", triad, axis, source.file));
  return noise;
}

/// Adds an axis's noise to its column, which holds these samples.
void add_noise(const AxisNoise& noise, std::span<const Range> samples, std::span<double> out) {
  if (noise.slow()) {
    std::vector<double> all(samples.back().end);
    noise.add_slow(all);
    std::size_t place = 0;
    for (const Range& range : samples)
      for (std::size_t i = range.begin; i < range.end; ++i) out[place++] += all[i];
  }
  std::size_t place = 0;
  for (const Range& range : samples) {
    noise.add_fast(range.begin, out.subspan(place, range.size()));
    place += range.size();
  }
}

std::vector<std::size_t> saturated(Recording& recording, const Limits& gyro, const Limits& accel) {
  std::vector<std::size_t> samples;
  if (!gyro.any() && !accel.any()) return samples;
  for (std::size_t k = 0; k < recording.size(); ++k)
    for (std::size_t axis = 0; axis < 6; ++axis) {
      const Limits& limits = axis < 3 ? gyro : accel;
      if (const double x = column(recording, axis)[k]; x > limits.low && x < limits.high) continue;
      samples.push_back(k);
      break;
    }
  return samples;
}

/// A truth made in memory, and the errors of its rig.
void check(const Truth& truth, const RigErrors& rig, const EffectSetting& setting, std::size_t steps) {
  std::vector<std::string> problems = problems_of(truth.model);
  if (!(truth.gravity >= 0 && std::isfinite(truth.gravity))) problems.push_back(fmt::format("gravity is {}; expected m/s^2", truth.gravity));
  for (const auto& [triad, noise] : {std::pair{"gyro_noise", &truth.gyro_noise}, std::pair{"accel_noise", &truth.accel_noise}})
    for (const double size : {noise->Q, noise->N, noise->B, noise->K, noise->resolution, noise->range})
      if (!(size >= 0 && std::isfinite(size))) problems.push_back(fmt::format("{}: a term is {}; expected 0 or more", triad, size));
  if (truth.latitude && !(std::abs(*truth.latitude) <= std::numbers::pi / 2))
    problems.push_back(fmt::format("latitude is {} rad; expected -pi/2 to pi/2", *truth.latitude));
  for (const EffectValue& e : truth.effects)
    if (const std::string problem = simulate::problem_of(e, setting); !problem.empty()) problems.push_back(problem);
  if (rig.values.size() != rig.sources.size())
    problems.push_back(fmt::format("the rig has {} errors of {} sources; expected one of each", rig.values.size(), rig.sources.size()));
  for (const RigErrorSource& source : rig.sources)
    if (const std::string problem = imulab::problem_of(source, steps); !problem.empty()) problems.push_back(problem);
  throw_problems("the truth of the simulation", problems);
}

}  // namespace

Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed, const RigErrors& rig) {
  validate(procedure);
  check(truth, rig, simulate::setting_of(procedure), procedure.steps_of(source).size());
  if (!procedure.site.latitude) throw Error("the site has no latitude; the Earth's rate depends on it; expected a latitude");
  Recording recording = ideal_recording(
      procedure, source, {earth_rate_enu(truth.latitude.value_or(*procedure.site.latitude)), truth.gravity, truth.model.lever_arm}, rig);
  if (source.gyro.unit == "count") recording.gyro_unit = "count";
  if (source.accel.unit == "count") recording.accel_unit = "count";
  const std::vector<Range> samples = recorded_samples(source, procedure.steps_of(source));
  const Limits gyro_limits = limits_of(truth.gyro_noise, source.gyro, recording.interval_s),
               accel_limits = limits_of(truth.accel_noise, source.accel, recording.interval_s);
  std::vector<TemperatureProfile::State> temperatures;
  const bool warms = std::any_of(truth.effects.begin(), truth.effects.end(),
                                 [](const EffectValue& e) { return find_effect(e.name)->needs & Effect::by_thermometer; });
  if (warms || truth.model.gyro.temperature || truth.model.accel.temperature || source.gyro_temperature || source.accel_temperature)
    temperatures =
        temperatures_at(samples, TemperatureProfile(recorded_motion(procedure, source, rig), procedure.rig_of(source)), recording.interval_s);
  recording.gyro_temperature = thermal_readings(source.gyro_temperature, temperatures, samples, seed, "gyro temperature of " + source.file);
  recording.accel_temperature = thermal_readings(source.accel_temperature, temperatures, samples, seed, "accel temperature of " + source.file);
  const std::vector<double> gyro_followed = followed_readings(truth.model.gyro, source.gyro_temperature, temperatures),
                            accel_followed = followed_readings(truth.model.accel, source.accel_temperature, temperatures);
  const auto number = std::find(procedure.recordings.begin(), procedure.recordings.end(), source) - procedure.recordings.begin();
  add_effects(recording, truth.effects, truth.gravity, static_cast<int>(number), temperatures);
  const std::vector<AxisNoise> noise = noise_of(truth, source, recording.interval_s, seed);
  // Isolated: a thread that waits here must not start an outer loop's next session on the same stack.
  isolate_parallel([&] {
    parallel_for(noise.size(), [&](std::size_t axis) { add_noise(noise[axis], samples, column(recording, axis)); });
    parallel_for((recording.size() + samples_per_task - 1) / samples_per_task, [&](std::size_t block) {
      const std::size_t begin = block * samples_per_task, size = std::min(samples_per_task, recording.size() - begin);
      const auto part = [&](const std::vector<double>& readings) {
        std::array<std::span<const double>, 3> columns;
        if (!readings.empty()) columns.fill(std::span(readings).subspan(begin, size));
        return columns;
      };
      MotionColumns out;
      for (std::size_t axis = 0; axis < 3; ++axis)
        out.rate[axis] = column(recording, axis).subspan(begin, size), out.force[axis] = column(recording, axis + 3).subspan(begin, size);
      decompensate(truth.model, part(gyro_followed), part(accel_followed), out);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        read_out(truth.gyro_noise.resolution, gyro_limits, out.rate[axis]);
        read_out(truth.accel_noise.resolution, accel_limits, out.force[axis]);
      }
    });
  });
  recording.saturated = saturated(recording, gyro_limits, accel_limits);
  return recording;
}

// Draws an IMU.

namespace {

using namespace simulate;

/// Each coefficient has a stream of its own draws: a new one does not shift another.
Vector3d drawn_vector(std::uint64_t seed, std::string_view purpose, double sigma) {
  const RandomStream draws(seed, purpose);
  Vector3d v;
  for (int i = 0; i < 3; ++i) v(i) = sigma * draws.normal(static_cast<std::uint64_t>(i));
  return v;
}

Matrix3d drawn_matrix(std::uint64_t seed, std::string_view purpose, double sigma_diagonal, double sigma_off_diagonal) {
  const RandomStream draws(seed, purpose);
  Matrix3d m;
  std::uint64_t draw = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = (i == j ? sigma_diagonal : sigma_off_diagonal) * draws.normal(draw++);
  return m;
}

/// Sizes uniform between two bounds, with either sign.
Matrix3d drawn_from(std::uint64_t seed, std::string_view purpose, const SizeRange& range) {
  const RandomStream draws(seed, purpose);
  Matrix3d m;
  std::uint64_t draw = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double u = 2 * draws.uniform(draw++) - 1;
      m(i, j) = std::copysign(range[0] + (range[1] - range[0]) * std::abs(u), u);
    }
  return m;
}

/// The errors of a triad besides its offset and scale factors.
void add_nonlinear(TriadModel& m, std::uint64_t seed, const std::string& triad, const SizeRange& misalignment, const SizeRange& quadratic,
                   const SizeRange& cubic, double drift, double curvature) {
  m.matrix = Matrix3d(m.matrix.diagonal().asDiagonal());
  Matrix3d cross = drawn_from(seed, "truth " + triad + " misalignment", misalignment);
  cross.diagonal().setZero();
  m.matrix += cross;
  m.quadratic = drawn_from(seed, "truth " + triad + " quadratic", quadratic).diagonal();
  m.cubic = drawn_from(seed, "truth " + triad + " cubic", cubic).diagonal();
  const double end = std::max(drawn_reference - drawn_temperatures[0], drawn_temperatures[1] - drawn_reference);
  m.thermal.col(1) = drawn_vector(seed, "truth " + triad + " drift", drift / end);
  m.thermal.col(2) = drawn_vector(seed, "truth " + triad + " curvature", curvature / (end * end));
  m.temperature = ThermalReading{"degC", drawn_reference, drawn_temperatures};
}

SensorModel drawn_model(const Grade& g, std::uint64_t seed) {
  SensorModel model;
  model.accel.offset = drawn_vector(seed, "truth accel.offset", g.accel_bias);
  model.gyro.offset = drawn_vector(seed, "truth gyro.offset", g.gyro_bias);
  const Matrix3d accel = drawn_matrix(seed, "truth accel.matrix", g.accel_scale, g.accel_misalignment);
  model.accel.matrix += accel.triangularView<Eigen::Lower>().toDenseMatrix();
  model.gyro.matrix += drawn_matrix(seed, "truth gyro.matrix", g.gyro_scale, g.gyro_misalignment);
  model.g_sensitivity = drawn_matrix(seed, "truth gyro.g_sensitivity", g.g_sensitivity, g.g_sensitivity);
  if (!g.ranges) return model;
  const NonlinearRanges& r = *g.ranges;
  add_nonlinear(model.accel, seed, "accel", r.accel_misalignment, r.accel_quadratic, r.accel_cubic, r.accel_drift, r.accel_curvature);
  add_nonlinear(model.gyro, seed, "gyro", r.gyro_misalignment, r.gyro_quadratic, r.gyro_cubic, r.gyro_drift, r.gyro_curvature);
  model.g_sensitivity = drawn_from(seed, "truth gyro.g_sensitivity size", r.g_sensitivity);
  return model;
}

/// A triad's thermal terms as functions of the recordings' readings. One in raw readings is assumed to be in these.
TriadModel as_recorded(const TriadModel& model, const Session& procedure, std::optional<ThermalSource> RecordingSource::*triad, bool drawn) {
  if (!model.temperature) return model;
  const ThermalSource* reading = nullptr;
  for (const RecordingSource& source : procedure.recordings) {
    const auto& here = source.*triad;
    if (!here) continue;
    if (reading && (here->unit != reading->unit || here->at_25_degC != reading->at_25_degC || here->per_K != reading->per_K))
      throw Error("thermal readings that differ between recordings; an IMU has one model; expected one unit and one relation to the temperature");
    reading = &*here;
  }
  const std::string& unit = model.temperature->unit;
  if (reading == nullptr || (!drawn && (unit == reading->unit || unit == "raw"))) return model;
  return with_readings(model, thermal_scale(unit), thermal_scale(*reading), reading->unit);
}

}  // namespace

Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given) {
  validate(procedure);
  const ImuDeclaration& imu = procedure.imu;
  const Grade* const spread = imu.grade ? &grade(*imu.grade) : nullptr;
  if (!given && !spread) throw Error("no IMU to simulate; expected its grade or its model");
  Truth truth;
  const NoiseModels noise = declared_noise(imu);
  truth.accel_noise = noise.accel, truth.gyro_noise = noise.gyro;
  // The grade's limits are in SI; a given IMU's raw readings need not be.
  if (given && !imu.accel_noise) truth.accel_noise.resolution = truth.accel_noise.range = 0;
  if (given && !imu.gyro_noise) truth.gyro_noise.resolution = truth.gyro_noise.range = 0;
  truth.model = given ? *given : drawn_model(*spread, seed);
  truth.model.accel = as_recorded(truth.model.accel, procedure, &RecordingSource::accel_temperature, !given);
  truth.model.gyro = as_recorded(truth.model.gyro, procedure, &RecordingSource::gyro_temperature, !given);
  if (!given && spread->ranges) truth.frame = BodyFrame::rig;
  truth.effects = drawn_effects(procedure, seed);
  truth.gravity = procedure.site.gravity() + procedure.site.gravity_sigma() * RandomStream(seed, "truth gravity").normal(0);
  if (const double sigma = procedure.site.latitude_sigma.value_or(0); procedure.site.latitude && sigma > 0)
    truth.latitude = *procedure.site.latitude + sigma * RandomStream(seed, "truth latitude").normal(0);
  return truth;
}

}  // namespace imulab
