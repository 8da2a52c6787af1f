#include "imulab/estimate/coarse/rest_start.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/coarse/coarse.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/kernel/rests_found.hpp"
#include "imulab/recording/gyro_saturation.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::coarse {

namespace {

/// Throws Error if gravity reads as less than half or more than twice itself. Uncalibrated accelerometers have errors below 20 %.
void check_accel_unit(const Recording& recording, const std::vector<RestMeans>& rests, double gravity) {
  if (recording.accel_unit == "count") return;
  std::vector<double> sizes;
  for (const RestMeans& rest : rests) sizes.push_back(rest.accel.norm());
  const double scale = gravity / median(sizes);
  if (!(scale > 0.5 && scale < 2))
    throw Error(
        fmt::format("{}: gravity at rest: {}", recording.name, kernel::scale_contradiction(Triad::accel, scale * Matrix3d::Identity(), recording)));
}

/// Returns true if the rests change the reading of every axis by a substantial part of gravity; otherwise the quadric would be fitted to noise.
bool gravity_on_every_axis(const RestStart& start) {
  const auto [low, high] = accel_extremes(start.rests);
  const Vector3d range = high - low;
  // Uncalibrated scales differ by less than a factor of 5, and the noise of a sample is below g / 50.
  return range.minCoeff() > 0.2 * range.maxCoeff() && (range.array() > 20 * start.noise.accel.array()).all();
}

/// Warns of rests that do not determine everything, if there is a simple reason.
void warn_of_poor_rests(RestStart& start) {
  constexpr std::size_t enough = 9;  // the accelerometers have as many coefficients
  const std::size_t n = start.rests.size();
  if (n < enough) start.findings.add<Code::few_rests>(n, n == 1 ? "" : "s");
  Matrix3d scatter = Matrix3d::Zero();
  for (const RestMeans& rest : start.rests) scatter += start.up(rest) * start.up(rest).transpose() / static_cast<double>(n);
  // A third in every direction is even; at 1/30, every rest is within about 10 deg of one plane.
  if (n > 1 && symmetric_eigenvalues(scatter)[0] < 1.0 / 30) start.findings.add<Code::rests_near_a_plane>();
}

/// Returns the raw noise for a declared density, and warns if the rests have another. A raw axis contributes to its column of the matrix.
Vector3d declared_sigma(std::string_view triad, double density, const Matrix3d& raw_matrix, double interval_s, const Vector3d& measured,
                        kernel::Findings& findings) {
  const Vector3d declared = (density / std::sqrt(interval_s)) * raw_matrix.colwise().norm().transpose().cwiseInverse();
  kernel::check_declared_noise(findings, triad, measured.norm() / declared.norm());
  return declared;
}

/// Sets the accelerometers of `start.model` and `start.prior`.
void start_accel(RestStart& start, const Recording& recording, double gravity) {
  std::vector<Vector3d> readings;
  for (const RestMeans& rest : start.rests) readings.push_back(start.accel(rest));
  const bool counts = recording.accel_unit == "count";
  auto coarse = gravity_on_every_axis(start) ? coarse_accel(readings, gravity) : std::nullopt;
  if (coarse && !counts && !near_identity(coarse->matrix)) coarse.reset();  // fitted to the noise of rests that are too similar
  if (!coarse && counts)
    throw Unsupported(fmt::format(
        "{}: {} rests do not determine the accelerometers' biases and scale factors: at least six rests with each axis up and down, or nine in "
        "different directions, are needed",
        recording.name, start.rests.size()));
  if (!coarse) {
    start.findings.add<Code::start_of_fit>("the rests alone do not give biases and scale factors: the fit started from the declared units");
    return;
  }
  start.model.accel.offset = coarse->offset;
  start.model.accel.matrix = coarse->matrix;
  if (!coarse->misalignment)
    start.findings.add<Code::start_of_fit>("the linear solution does not determine the accelerometers' misalignments: the fit started from zero");
  if (!counts) return;
  start.prior.accel.offset = coarse->offset;
  start.prior.accel.matrix = coarse->matrix.diagonal().asDiagonal();
}

}  // namespace

RestStart start_from_rests(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, double gravity) {
  if (ranges.empty())
    throw Unsupported(
        fmt::format("{}: no rests in {:.3g} s at {:.3g} Hz: the IMU was never still for long enough; hold it still in many orientations",
                    recording.name, static_cast<double>(recording.size()) * recording.interval_s, 1 / recording.interval_s));
  kernel::expect_alive(recording, Triad::accel, "without it nothing can be calibrated");
  RestStart start;
  start.first_s = recording.time_s(0);
  start.rests = summarize_rests(recording, without_ends_of_turns(recording, ranges));
  check_accel_unit(recording, start.rests, gravity);
  start.scaling = choose_scaling(recording, start.rests);
  start.noise = measure_noise(recording, start.rests);
  start.means = measure_mean_noise(recording, start.rests);
  kernel::check_gyro_steps(start.findings, start.means);
  for (SensorModel* model : {&start.model, &start.prior}) {
    model->accel.raw_unit = recording.accel_unit;
    model->gyro.raw_unit = recording.gyro_unit;
  }
  start_accel(start, recording, gravity);
  warn_of_poor_rests(start);
  if (imu.accel_noise_density)
    start.means.sample.accel = start.noise.accel =
        declared_sigma("accelerometers", *imu.accel_noise_density, to_raw(start.model, start.scaling).accel.matrix, recording.interval_s,
                       start.noise.accel, start.findings);
  limit_noise(start);
  return start;
}

RestStart start_from_rests(const CalibrationInput& input, std::string_view method) {
  const Recording& recording = kernel::only_recording(input, method);
  kernel::Findings findings;
  constexpr double part_K = 2;  // biases follow the temperature, and the mean of a warming rest has that of no temperature
  RestOptions options;
  if (const auto thermometer = thermometer_of(recording, input.session.source_of(recording.name)))
    options.part = part_K * std::abs(thermometer->per_K);
  const std::vector<Range> rests = kernel::rests_found(input, recording, findings, options);
  RestStart start = start_from_rests(recording, rests, input.session.imu, input.session.site.gravity());
  findings.append(start.findings);
  start.findings = std::move(findings);
  return start;
}

bool near_identity(const Matrix3d& matrix) { return (matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.2; }

void limit_noise(RestStart& start) {
  for (SampleNoise* noise : {&start.noise, &start.means.sample}) {
    noise->accel = noise->accel.cwiseMax(1e-8 * start.scaling.accel_scale);
    noise->gyro = noise->gyro.cwiseMax(1e-8 * start.scaling.gyro_scale);
  }
}

kernel::SeenOfUnit seen_of(const RestStart& start, const Recording& recording, double gravity) {
  const SensorModel model = to_raw(start.model, start.scaling);
  const double per_sample = std::sqrt(recording.interval_s);
  Vector3d rate = Vector3d::Zero();
  for (const RestMeans& rest : start.rests) rate += model.gyro.matrix * rest.gyro / static_cast<double>(start.rests.size());
  kernel::SeenOfUnit seen = kernel::seen_of_axes(per_sample * kernel::output_sigma(model.accel.matrix, start.noise.accel),
                                                 per_sample * kernel::output_sigma(model.gyro.matrix, start.noise.gyro), model.accel.offset, rate);
  // Offsets beyond any IMU's belong to counts; gyro offsets below the Earth's rate cannot be separated from it.
  if (!(seen.accel_offset < 0.2 * gravity)) seen.accel_offset = 0;
  if (!(seen.gyro_offset > 2 * earth_rate && seen.gyro_offset < 1)) seen.gyro_offset = 0;
  return seen;
}

void use_declared_gyro_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu) {
  if (!imu.gyro_noise_density) return;
  start.means.sample.gyro = start.noise.gyro = declared_sigma("gyros", *imu.gyro_noise_density, to_raw(start.model, start.scaling).gyro.matrix,
                                                              recording.interval_s, start.noise.gyro, start.findings);
}

std::optional<double> explained_turning(const Recording& recording, const RestStart& start, const Matrix3d& gyro) {
  constexpr std::size_t fewest = 3;
  constexpr double least_turn = 10 * unit::deg;
  const Vector3d at_rest = start.scaling.gyro(mean_gyro(start.rests));
  const GyroSaturation saturation(recording);
  std::size_t turns = 0;
  double turned = 0, missed = 0;  // squares
  for (std::size_t k = 0; k + 1 < start.rests.size(); ++k) {
    const Range between{start.rests[k].range.end, start.rests[k + 1].range.begin};
    const Vector3d begin = start.up(start.rests[k]), end = start.up(start.rests[k + 1]);
    if (begin.dot(end) > std::cos(least_turn) || saturation.in(between) > 0 || recording.gaps_in({between.begin, between.end + 1}) > 0) continue;
    Vector3d carried = begin;  // gravity turns relative to the IMU opposite to the IMU's turning
    for (std::size_t i = between.begin; i < between.end; ++i)
      carried = rotation_exp(-recording.interval_s * (gyro * (start.scaling.gyro(reading_at(recording.gyro, i)) - at_rest))) * carried;
    turned += (end - begin).squaredNorm();
    missed += (end - carried).squaredNorm();
    ++turns;
  }
  if (turns < fewest) return std::nullopt;
  return 1 - missed / turned;
}

std::optional<Matrix3d> coarse_gyro_in_common_turns(const Recording& recording, const RestStart& start) {
  const std::optional<Matrix3d> coarse = coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  // Scale errors of a third still explain nine tenths; gyros unrelated to the turns explain nothing or less.
  constexpr double least = 0.5;
  const auto by_coarse = coarse ? explained_turning(recording, start, *coarse) : std::nullopt;
  const auto as_declared = recording.gyro_unit != "count" ? explained_turning(recording, start, Matrix3d::Identity()) : std::nullopt;
  const double best = std::max(by_coarse.value_or(-HUGE_VAL), as_declared.value_or(-HUGE_VAL));
  if ((by_coarse || as_declared) && best < least)
    throw Unsupported(
        fmt::format("{}: the gyros do not turn with the accelerometers: they explain {:.0f} % of the turning of gravity between the rests; "
                    "check that both triads are of one recording, with stamps of one clock",
                    recording.name, 100 * std::max(0.0, best)));
  if (!coarse || recording.gyro_unit == "count") return coarse;
  const bool lost = !recording.gaps.empty() || !GyroSaturation(recording).samples().empty();  // the turns that determine the scale were lost
  if (!as_declared) return lost ? std::nullopt : coarse;
  return *as_declared > *by_coarse && !near_identity(*coarse) ? std::nullopt : coarse;
}

}  // namespace imulab::coarse
