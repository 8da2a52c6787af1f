// The uncertainties of both methods before any data: their own conditions, at the ideal readings of a procedure with the declared noise.
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/estimate/rests/static_problem.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::rests {

namespace {

/// What an ideal IMU with the declared noise reads on a procedure.
struct Foreseen {
  Session session;  ///< with the noise densities
  Recording recording;
  kernel::RestStart start;
};

/// Of the three axes of a triad: a sample's noise, and what the rounding of readings keeps from a mean.
void set_noise(MeanNoise& means, Vector3d SampleNoise::*triad, const NoiseModel& noise, double interval_s) {
  const double sigma = noise.N / std::sqrt(interval_s);
  means.sample.*triad = Vector3d::Constant(sigma);
  means.step.*triad = Vector3d::Constant(noise.resolution);
  means.rounding.*triad = Vector3d::Constant(std::sqrt(rounding_variance(noise.resolution, sigma)));
}

Foreseen foresee(const Session& procedure) {
  const RecordingSource source = kernel::only_source(procedure);
  Foreseen out{procedure, {}, {}};
  const NoiseModels noise = errors_at(procedure.file, [&] { return declared_noise(procedure.imu); });
  out.session.imu.accel_noise_density = noise.accel.N, out.session.imu.gyro_noise_density = noise.gyro.N;
  const double gravity = errors_at(procedure.file, [&] { return procedure.site.gravity(); });
  // Without a latitude the method estimates both parts of Earth's rate, at any latitude alike.
  const double latitude = procedure.site.latitude.value_or(45 * unit::deg);
  out.recording = ideal_recording(procedure, source, {earth_rate_enu(latitude), gravity});
  const auto is_hold = [](const Step& step) { return step.kind == StepKind::hold; };
  std::vector<Range> rests;  // of the holds: an ideal recording shows no others
  if (std::any_of(procedure.steps.begin(), procedure.steps.end(), is_hold)) rests = rests_of(out.recording, procedure).ranges;
  if (rests.empty()) throw Error(procedure.file + ": no hold among the steps; expected at least one, since the method needs rests");
  kernel::RestStart& start = out.start;
  start.rests = summarize_rests(out.recording, rests);
  start.scaling = choose_scaling(out.recording, start.rests);
  set_noise(start.means, &SampleNoise::accel, noise.accel, out.recording.interval_s);
  set_noise(start.means, &SampleNoise::gyro, noise.gyro, out.recording.interval_s);
  start.noise = start.means.sample;
  kernel::limit_noise(start);
  SensorModel ideal;
  ideal.accel.raw_unit = out.recording.accel_unit, ideal.gyro.raw_unit = out.recording.gyro_unit;
  start.model = start.prior = to_scaled(ideal, start.scaling);
  return out;
}

template <class Problem>
Prediction prediction(std::string_view method, const Foreseen& of, Problem problem) {
  const Fit fit = foreseen(problem);
  Prediction out = prediction_of(calibration_of(method, problem, fit, of.session));
  out.notes = of.start.findings.notes;
  return out;
}

}  // namespace

Prediction predict_static(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  Foreseen f = foresee(procedure);
  const bool with_gyros = start_gyros_at_rest(f.start, f.recording, f.session);
  const std::vector<CoefficientIndex> indices = choose_coefficients(f.start, f.session, terms, static_coefficients(with_gyros), "static");
  return prediction("static", f, StaticProblem(f.start, f.session.site, indices, with_gyros));
}

Prediction predict_handheld(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  Foreseen f = foresee(procedure);
  const std::vector<CoefficientIndex> indices = choose_coefficients(f.start, f.session, terms, handheld_coefficients(), "handheld");
  return prediction("handheld", f,
                    HandheldProblem(f.recording, f.start, f.session.site, indices, declared_turns(f.session, f.session.source_of(f.recording.name))));
}

}  // namespace imulab::rests
