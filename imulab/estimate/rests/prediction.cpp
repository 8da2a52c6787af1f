// Uncertainties of both methods before any data, from their own conditions at the ideal readings of a procedure with the declared noise.
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/problem.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/temperature.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

namespace {

/// The readings of an ideal IMU in a procedure, with the declared noise.
struct Foreseen {
  Session session;  ///< includes the noise densities
  Recording recording;
  coarse::RestStart start;
};

/// Sets the noise of a triad's three axes: of a sample, and the rounding error that remains in a mean.
void set_noise(MeanNoise& means, Vector3d SampleNoise::*triad, const NoiseModel& noise, double interval_s) {
  const double sigma = noise.N / std::sqrt(interval_s);
  means.sample.*triad = Vector3d::Constant(sigma);
  means.step.*triad = Vector3d::Constant(noise.resolution);
  means.rounding.*triad = Vector3d::Constant(std::sqrt(rounding_variance(noise.resolution, sigma)));
}

/// Adds what thermal sensors without noise read at the steps' set points.
void add_temperatures(Recording& recording, const Session& procedure, const RecordingSource& source) {
  if (!source.gyro_temperature && !source.accel_temperature) return;
  const std::vector<Range> samples = recorded_samples(source, procedure.steps_of(source));
  const TemperatureProfile profile(recorded_motion(procedure, source, {}), procedure.rig_of(source));
  const std::vector<TemperatureProfile::State> temperatures = temperatures_at(samples, profile, recording.interval_s);
  for (auto& [columns, sensor] :
       {std::pair{&recording.gyro_temperature, source.gyro_temperature}, {&recording.accel_temperature, source.accel_temperature}}) {
    std::optional<ThermalSource> exact = sensor;
    if (exact) exact->noise = 0;
    *columns = thermal_readings(exact, temperatures, samples, 0, "");
  }
}

Foreseen foresee(const Session& procedure) {
  const RecordingSource source = kernel::only_source(procedure);
  Foreseen out{procedure, {}, {}};
  const NoiseModels noise = errors_at(procedure.file, [&] { return declared_noise(procedure.imu); });
  out.session.imu.accel_noise_density = noise.accel.N, out.session.imu.gyro_noise_density = noise.gyro.N;
  const double gravity = errors_at(procedure.file, [&] { return procedure.site.gravity(); });
  // Without a latitude, the method estimates both parts of the Earth's rate; the result is the same for any latitude.
  const double latitude = procedure.site.latitude.value_or(45 * unit::deg);
  out.recording = ideal_recording(procedure, source, {earth_rate_enu(latitude), gravity});
  add_temperatures(out.recording, procedure, source);
  const auto is_hold = [](const Step& step) { return step.kind == StepKind::hold; };
  std::vector<Range> rests;  // rests are the holds: an ideal recording has no others
  if (std::any_of(procedure.steps.begin(), procedure.steps.end(), is_hold)) rests = rests_of(out.recording, procedure).ranges;
  if (rests.empty()) throw Error(procedure.file + ": no hold among the steps; expected at least one, since the method needs rests");
  coarse::RestStart& start = out.start;
  start.rests = summarize_rests(out.recording, rests);
  start.scaling = choose_scaling(out.recording, start.rests);
  set_noise(start.means, &SampleNoise::accel, noise.accel, out.recording.interval_s);
  set_noise(start.means, &SampleNoise::gyro, noise.gyro, out.recording.interval_s);
  start.noise = start.means.sample;
  coarse::limit_noise(start);
  SensorModel ideal;
  ideal.accel.raw_unit = out.recording.accel_unit, ideal.gyro.raw_unit = out.recording.gyro_unit;
  start.model = start.prior = to_scaled(ideal, start.scaling);
  return out;
}

template <class Problem>
Prediction prediction(std::string_view method, const Foreseen& of, const PredictionOptions& options, Problem problem) {
  const Fit fit = foreseen(problem);
  Prediction out = prediction_of(calibration_of(method, problem, fit, of.session));
  out.notes = of.start.findings.notes();
  const std::vector<std::string> warnings = of.start.findings.warnings();
  out.notes.insert(out.notes.end(), warnings.begin(), warnings.end());
  out.missed = shortfalls(out, options.requirements);
  return out;
}

}  // namespace

Prediction predict_static(const Session& procedure, const PredictionOptions& options) {
  Foreseen f = foresee(procedure);
  const bool with_gyros = start_gyros_at_rest(f.start, f.recording, f.session);
  const std::vector<CoefficientIndex> indices =
      choose_coefficients(f.start, f.session, f.recording, options.effects, options.terms, static_coefficients(with_gyros), "static");
  return prediction("static", f, options, StaticProblem(f.start, f.session.site, indices, with_gyros));
}

Prediction predict_handheld(const Session& procedure, const PredictionOptions& options) {
  Foreseen f = foresee(procedure);
  const std::vector<CoefficientIndex> indices =
      choose_coefficients(f.start, f.session, f.recording, options.effects, options.terms, handheld_coefficients(), "handheld");
  return prediction("handheld", f, options,
                    HandheldProblem(f.recording, f.start, f.session.site, indices, declared_turns(f.session, f.session.source_of(f.recording.name))));
}

namespace {

bool enough_directions(const RestEvidence& e) { return e.rests >= 9 && e.determined > 8.5; }
std::string counted(std::size_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }
std::string directions(const RestEvidence& e) { return fmt::format("{}, {:.0f} of 9 parameters", counted(e.rests, "rest"), e.determined); }

}  // namespace

MethodSupport support_static(const RestEvidence& e) {
  if (e.sweep) return {true, "one attitude at many temperatures: the gyros' biases, and how all follow the temperature"};
  const bool enough = enough_directions(e);
  return {enough, directions(e) + (enough ? "" : ": at least nine rests in different directions are needed")};
}

MethodSupport support_handheld(const RestEvidence& e) {
  if (e.sweep) return {true, "as static; together with a log by hand, all coefficients"};
  const bool still = enough_directions(e), turns = still && e.explained;
  return {turns, fmt::format("{}, {}{}", directions(e), counted(e.turns, "turn"),
                             turns   ? ""
                             : still ? ": the gyros do not explain the turns"
                                     : ": as for static, and turns about all axes")};
}

}  // namespace imulab::rests
