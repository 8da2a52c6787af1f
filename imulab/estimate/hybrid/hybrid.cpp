#include "imulab/estimate/hybrid/hybrid.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/coarse/coarse.hpp"
#include "imulab/estimate/coarse/rest_start.hpp"
#include "imulab/estimate/hybrid/latitude_at_rest.hpp"
#include "imulab/estimate/hybrid/quality.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/kernel/rests_found.hpp"
#include "imulab/model/conclusion.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab::hybrid {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Starts the gyros from the Earth's rate if the rests determine it, else from the declared unit or, for counts, from the motion of gravity; the
/// offset follows from the rests.
void start_gyro(coarse::RestStart& start, const Recording& recording, double latitude) {
  TriadModel& gyro = start.model.gyro;
  const bool counts = recording.gyro_unit == "count";
  const auto at_rest = coarse::coarse_gyro_at_rest(start.rests, start.model, start.scaling, earth_rate * std::sin(latitude));
  if (at_rest && !counts && (at_rest->matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.05) {
    gyro.matrix = at_rest->matrix;
    gyro.offset = at_rest->offset;
    start.findings.add<Code::start_of_fit>("gyros started from the Earth's rate at rest");
    return;
  }
  if (counts) {
    const auto in_motion = coarse::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
    if (!in_motion)
      throw Unsupported(recording.name + ": gyro: the motion does not turn the IMU about all its axes; readings in counts need that for their scale");
    gyro.matrix = *in_motion;
  }
  const Vector3d mean = gyro.matrix * start.scaling.gyro(mean_gyro(start.rests));
  if (mean.norm() > 2 * earth_rate) gyro.offset = -mean;  // a smaller mean is mostly the Earth's rate
  start.findings.add<Code::start_of_fit>(counts ? "gyros started from the motion of gravity between the rests"
                                                : "gyros started from the declared unit");
}

void check_axes(const Recording& recording, const coarse::RestStart& start) {
  const auto in_motion = coarse::coarse_gyro_in_common_turns(recording, start);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty())
    throw Error(recording.name + ": " + wrong + ", as gravity turns in the IMU; expected right-handed axes, the same for both triads");
  if (recording.gyro_unit != "count") kernel::expect_gyro_scale(*in_motion, recording);
}

/// Uses the noise of quiet seconds. Rounded readings without own noise have a constant error in a rest, like the mean of such white noise.
void use_quiet_noise(coarse::RestStart& start, const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu) {
  std::vector<double> lengths;
  for (const Range& rest : rests) lengths.push_back(static_cast<double>(rest.size()));
  const double root_of_length = std::sqrt(median(std::move(lengths)));
  const std::size_t second = std::max<std::size_t>(5, static_cast<std::size_t>(std::lround(1 / recording.interval_s)));
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<Index>(j);
    const auto quiet = [&](double noise, const std::vector<double>& readings, double rounding) {
      return std::hypot(std::min(noise, quiet_noise(readings, rests, second)), root_of_length * rounding);
    };
    if (!imu.accel_noise_density) start.noise.accel[axis] = quiet(start.noise.accel[axis], recording.accel[j], start.means.rounding.accel[axis]);
    start.noise.gyro[axis] = quiet(start.noise.gyro[axis], recording.gyro[j], start.means.rounding.gyro[axis]);
  }
  coarse::limit_noise(start);
}

/// Returns rests, their noise, and a coarse solution of both triads (Cheng 2014 sec 1.2). Throws like coarse::start_from_rests, and throws Error for
/// swapped, reversed or left-handed axes.
coarse::RestStart coarse_start(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double latitude,
                               double gravity) {
  coarse::RestStart start = coarse::start_from_rests(recording, rests, imu, gravity);
  use_quiet_noise(start, recording, rests, imu);
  start_gyro(start, recording, latitude);
  coarse::use_declared_gyro_noise(start, recording, imu);
  check_axes(recording, start);
  return start;
}

/// Lower bounds of measured white noise, below any sensor's. Integration residuals of noise-free readings would otherwise outweigh any prior.
constexpr double least_accel_density = 1e-7;  // m/s^2/sqrt(Hz): 0.01 ug/sqrt(Hz)
constexpr double least_gyro_density = 1e-9;   // rad/s/sqrt(Hz): 3e-6 deg/sqrt(h)

/// Returns the noise of the calibrated output: white noise from the samples or as declared. With the full noise of a grade, quantization is a
/// separate term, and the samples contain more than the white noise. Other terms are as declared.
Noise noise_of(const SampleNoise& raw, const SensorModel& coarse, const Recording& recording, const ImuDeclaration& imu) {
  const NoiseModels declared = declared_terms(imu);
  const bool full = imu.noise == NoiseTerms::full;
  const auto density = [&](const TriadModel& triad, const Vector3d& sigma, double least, double of_grade) {
    const Vector3d shown = std::sqrt(recording.interval_s) * kernel::output_sigma(triad.matrix, sigma);
    return full && of_grade > 0 ? Vector3d(Vector3d::Constant(of_grade)) : Vector3d(shown.cwiseMax(least));
  };
  return in_place::noise_of(density(coarse.gyro, raw.gyro, imu.gyro_noise_density ? 0 : least_gyro_density, declared.gyro.N),
                            density(coarse.accel, raw.accel, imu.accel_noise_density ? 0 : least_accel_density, declared.accel.N), declared,
                            recording.interval_s * static_cast<double>(recording.size()));
}

/// Returns true if the rests have no noise in a triad without declared noise. Integration residuals are then larger and replace it.
bool shows_no_noise(const Noise& noise, const ImuDeclaration& imu) {
  return (!imu.accel_noise_density && noise.accel.minCoeff() <= least_accel_density) ||
         (!imu.gyro_noise_density && noise.gyro.minCoeff() <= least_gyro_density);
}

void warn_of_short_rests(const std::vector<Range>& rests, const std::vector<Range>& still, kernel::Findings& findings) {
  const auto n = std::inner_product(rests.begin(), rests.end(), still.begin(), std::size_t{0}, std::plus<>(), std::equal_to<>());
  if (2 * n > rests.size()) findings.add<Code::short_rests>(n, rests.size(), 5 * in_place::settling_time);
}

/// An axis whose readings are late by a sample, because of a filter of its own or a register that is read too early. In turns this resembles
/// misalignments, a g-sensitivity or another latitude, none of which fits.
struct LateAxis {
  std::size_t axis = 0;            ///< 0 to 2: gyros; 3 to 5: accelerometers
  int samples = 0;                 ///< delay in samples; -1: early
  double scatter = 0, before = 0;  ///< scatter of the velocities relative to their noise, with and without the shift
};

/// Returns the recording with that axis shifted to compensate the delay.
Recording shift_by_one_sample(Recording recording, const LateAxis& late) {
  std::vector<double>& readings = (late.axis < 3 ? recording.gyro : recording.accel)[late.axis % 3];
  if (readings.empty()) return recording;
  if (late.samples > 0)
    std::shift_left(readings.begin(), readings.end(), 1);  // the last reading is repeated
  else
    std::shift_right(readings.begin(), readings.end(), 1);
  return recording;
}

/// Returns the axis that explains most of the misfit; nothing if the velocities fit or no axis halves their scatter.
std::optional<LateAxis> late_axis(const Data& data, const Iterate& converged) {
  constexpr double fits = 1.5;  // as in turns with ramps shorter than two samples
  LateAxis best{0, 0, HUGE_VAL, scatter_of(data, converged)};
  if (!(best.before > fits && best.before < other_data)) return std::nullopt;
  for (std::size_t axis = 0; axis < 6; ++axis)
    for (const int samples : {1, -1}) {
      const Recording moved = shift_by_one_sample(data.recording, {axis, samples});
      const Data trial{moved, data.blocks, data.place, data.noise, data.coarse, data.terms, data.unmodeled};
      if (const double scatter = scatter_of(trial, repeated(trial, converged)); scatter < best.scatter)
        best.axis = axis, best.samples = samples, best.scatter = scatter;
    }
  return best.scatter < 0.5 * best.before ? std::optional(best) : std::nullopt;
}

void add_curves(const Data& data, const Iterate& iterate, double interval, CalibrationResult& out) {
  const Iterate last = repeated(data, iterate, interval);
  for (const Index s : last.states.corrections()) {
    ConvergenceCurve curve{std::string(coefficient(last.states.corrects(s)).name), {}, {}};
    for (const CurvePoint& point : last.pass.curve) {
      curve.residual.push_back(last.total[s] + point.x[s]);
      curve.sigma.push_back(point.sigma[s]);
    }
    out.curves.push_back(std::move(curve));
  }
  for (const CurvePoint& point : last.pass.curve) out.curve_time.push_back(point.time);
  out.iterations = last.iterations;
}

/// Returns the latitude that the gyros measure at rest with this model if it contradicts the declared one. `scale`: relative standard deviation of
/// the model's gyro scales.
std::optional<SeenLatitude> seen_latitude(const Data& data, const std::vector<RestMeans>& rests, const SensorModel& model, double scale) {
  // The mean of three axes is the part of the g-sensitivity that is equal on all.
  const double equal = data.terms.optional.contains(Group::g_sensitivity) ? data.terms.priors.sizes.g_sensitivity / std::sqrt(3) : 0;
  return latitude_against(data.place.latitude, data.place.latitude_sigma, rests, model,
                          {data.noise.gyro.maxCoeff(), scale, equal, data.place.gravity});
}

/// Returns the same with the converged scales.
std::optional<SeenLatitude> seen_latitude(const Data& data, const std::vector<RestMeans>& rests, const Iterate& converged) {
  const Index scales = converged.states.first(Group::gyro_matrix);
  double variance = 0;
  for (Index i = 0; i < 9; i += 4) variance = std::max(variance, converged.pass.covariance(scales + i, scales + i));
  return seen_latitude(data, rests, converged.about.model, std::max(1.0, scatter_of(data, converged)) * std::sqrt(variance));
}

/// Calibrates. `findings`: findings so far; `last`: findings for the end of the list.
CalibrationResult calibrated(const Recording& recording, const std::vector<Range>& rests, const Session& session, const CalibrationOptions& options,
                             kernel::Findings findings, const kernel::Findings& last) {
  Place place = place_of(session.site);
  if (options.effects) place = with_latitude_effect(place, session);
  const bool turntable = on_turntable(session);
  kernel::expect_alive(recording, Triad::gyro, "the method needs all gyros");
  const std::vector<Range> still = in_place::still_parts(recording, rests);
  const coarse::RestStart start = coarse_start(recording, still, session.imu, place.latitude, place.gravity);
  in_place::Blocks cut = in_place::cut_into_blocks(recording, still, turntable);
  const SensorModel coarse = to_raw(start.model, start.scaling);
  const kernel::SeenOfUnit seen_of_unit = coarse::seen_of(start, recording, place.gravity);
  Data data{.recording = recording,
            .blocks = std::move(cut.blocks),
            .place = place,
            .noise = noise_of(start.noise, coarse, recording, session.imu),
            .coarse = coarse,
            .terms = terms_of(session, options.terms, seen_of_unit, recording.interval_s)};
  data.unmodeled = unmodeled_of(session, recording, data.blocks, coarse, options.terms, seen_of_unit, options.effects);
  const bool corrected = last.has(Code::wrong_latitude);
  constexpr double of_any_unit = 0.05;  // for scales of an uncalibrated unit
  std::optional<SeenLatitude> seen;
  if (!corrected) seen = seen_latitude(data, start.rests, coarse, of_any_unit);
  Converged result = seen ? Converged{first_iterate(data)} : converge(data, options.significance);
  if (!seen && shows_no_noise(data.noise, session.imu)) {
    const double scatter = scatter_of(data, result.last);
    data.noise.accel *= std::max(1.0, scatter), data.noise.gyro *= std::max(1.0, scatter);
    if (scatter > 1) result = converge(data, options.significance);
  }
  if (!corrected && !seen && result.last.converged) seen = seen_latitude(data, start.rests, result.last);
  if (seen) {  // replaces the latitude of the site and is estimated jointly
    Session there = session;
    there.site.latitude = seen->value;
    there.site.latitude_sigma = seen->sigma;
    there.site.given_gravity_sigma = there.site.gravity_sigma();
    there.site.latitude_sigma = 5 * seen->sigma;  // the fit determines it better
    kernel::Findings instead;
    instead.add<Code::latitude_by_rests>(seen->value / unit::deg, seen->sigma / unit::deg, place.latitude / unit::deg);
    instead.add<Code::wrong_latitude>();
    instead.append(last);
    return calibrated(recording, rests, there, options, std::move(findings), instead);
  }
  if (const auto late = !last.doubtful() ? late_axis(data, result.last) : std::nullopt) {
    kernel::Findings instead;
    const LateAxis& axis = *late;
    const char* const triad = axis.axis < 3 ? "gyro" : "accelerometer";
    const char* const when = axis.samples > 0 ? "later" : "earlier";
    instead.add<Code::late_axis>("xyz"[axis.axis % 3], triad, when, axis.before, axis.scatter);
    return calibrated(shift_by_one_sample(recording, *late), rests, session, options, std::move(findings), instead);
  }
  findings.append(start.findings);
  for (const std::string& warning : cut.warnings) findings.add<Code::motion_left_out>(warning);
  warn_of_short_rests(rests, still, findings);
  CalibrationResult out{calibration_of(data, result.last), coarse, {}, {}, result.last.iterations};
  out.calibration.imu = session.imu.name;
  report(data, result, session.site, out.calibration, findings);
  add_effects(data, result.last, out.calibration, findings);
  findings.append(last);
  kernel::conclude(out.calibration, findings);
  if (options.hybrid.curve_interval > 0) add_curves(data, result.last, options.hybrid.curve_interval, out);
  return out;
}

}  // namespace

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Recording& recording = kernel::only_recording(input, "hybrid");
  kernel::Findings findings;
  const std::vector<Range> rests = kernel::rests_found(input, recording, findings);
  return calibrated(recording, rests, input.session, options, findings, {});
}

}  // namespace imulab::hybrid
