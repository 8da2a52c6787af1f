#include "imulab/estimate/extrinsics/reference.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/extrinsics/body_fit.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/model/frame_axes.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace imulab::extrinsics {
namespace {

using Eigen::Index;
using Errors = Eigen::Matrix<double, own_columns, 1>;

constexpr double most_used_s = 600;  // a vehicle turns seldom; the fit needs 1 GB for it

/// Returns the model of an IMU with these errors of its readings.
SensorModel model_of(const ImuState& state) {
  SensorModel out;
  out.accel.raw_unit = "m/s^2", out.gyro.raw_unit = "rad/s";
  const Matrix3d of_accels = Matrix3d::Identity() + state.matrix(accel_matrix), of_gyros = Matrix3d::Identity() + state.matrix(gyro_matrix);
  const Vector3d c = state.errors.segment<3>(accel_offset), b = state.errors.segment<3>(gyro_offset);
  out.accel.matrix = of_accels.inverse();
  out.accel.offset = -out.accel.matrix * c;
  out.gyro.matrix = of_gyros.inverse();
  out.g_sensitivity = -out.gyro.matrix * state.matrix(g_sensitivity) * of_accels;
  out.gyro.offset = -out.gyro.matrix * (b + state.matrix(g_sensitivity) * c);
  return out;
}

/// Returns the derivatives of the coefficients by the errors: central differences over one standard uncertainty.
Eigen::MatrixXd by_errors(const ImuState& state, const std::vector<CoefficientIndex>& estimated, const Errors& sigma) {
  Eigen::MatrixXd out(std::ssize(estimated), own_columns);
  for (Index k = 0; k < own_columns; ++k) {
    ImuState below = state, above = state;
    below.errors[k] -= sigma[k], above.errors[k] += sigma[k];
    out.col(k) = (coefficient_values(model_of(above), estimated) - coefficient_values(model_of(below), estimated)) / (2 * sigma[k]);
  }
  return out;
}

/// The only IMU of the input that is not the reference, and the reference.
struct Pair {
  BodyImu reference, other;
};
Pair pair_of(const CalibrationInput& input, const ReferenceImu& reference) {
  std::map<std::string, BodyImu> imus;
  for (const Recording& recording : input.recordings) {
    const RecordingSource source = input.session.source_of(recording.name);
    if (imus.contains(source.imu)) throw Error(fmt::format("{}: has two recordings of IMU {}; expected one of each", recording.name, source.imu));
    imus[source.imu] = {.name = source.imu, .recording = recording, .clock_zero_ns = source.time.zero_ns()};
  }
  const auto found = imus.find(reference.imu);
  if (found == imus.end() || imus.size() != 2) {
    std::vector<std::string> names;
    for (const auto& [name, imu] : imus) names.push_back(name.empty() ? "one without a name" : name);
    throw Error(
        fmt::format("the method reference takes the recording of one IMU and that of its reference {}; got {} (imu = \"NAME\" in [[recording]])",
                    reference.imu, fmt::join(names, ", ")));
  }
  Pair out{std::move(found->second), {}};
  imus.erase(found);
  out.other = std::move(imus.begin()->second);
  out.reference.calibration = reference.calibration, out.reference.grade = reference.grade;
  out.other.grade = input.session.imu.grade.value_or("mems");
  return out;
}

void add_mounting(const Mounting& m, Quality& quality) {
  constexpr std::array axes{"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    quality.rig_errors.push_back(
        {fmt::format("mounting.lever_arm.{}", axes[static_cast<std::size_t>(i)]), any_arm, m.lever_arm[i], m.uncertainty(arm + i)});
  quality.rig_errors.push_back({"mounting.clock_offset", any_offset, m.clock_offset, m.uncertainty(offset)});
  quality.rig_errors.push_back({"mounting.clock_drift", any_drift, m.clock_drift, m.uncertainty(drift)});
}

/// Sums of an IMU's residuals in windows of time.
struct WindowSums {
  std::vector<Vector3d> sum;
  std::vector<double> samples;
};
WindowSums in_windows(const BodyRates& rates, double begin, double window, std::size_t count) {
  WindowSums out{std::vector<Vector3d>(count, Vector3d::Zero()), std::vector<double>(count, 0)};
  for (std::size_t i = 0; i < rates.time.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::clamp((rates.time[i] - begin) / window, 0., static_cast<double>(count - 1)));
    out.sum[at] += Vector3d(rates.residual[0][i], rates.residual[1][i], rates.residual[2][i]), ++out.samples[at];
  }
  return out;
}

/// What the offsets of windows depart from those of the result, by the difference of both IMUs' residuals: the motion has its share of each.
void add_offsets_over_time(const BodyFit& body, const std::vector<BodyImu>& imus, CalibrationResult& result) {
  const ImuState &first = body.fit->states()[0], &own = body.fit->states()[1];
  const std::vector<double> times = body.fit->rates(1).time;
  constexpr double least_s = 5, most_windows = 100;
  const double begin = times.front(), window = std::max(least_s, (times.back() - begin) / most_windows);
  const auto count = static_cast<std::size_t>((times.back() - begin) / window) + 1;
  const std::int64_t between_clocks = imus[0].clock_zero_ns + imus[0].recording.time_ns.front() - imus[1].clock_zero_ns;
  std::vector<std::size_t> filled;
  for (const auto sensor : {MotionFit::gyros, MotionFit::accels}) {
    const bool gyro = sensor == MotionFit::gyros;
    const WindowSums mine = in_windows(body.fit->rates(1, sensor), begin, window, count),
                     reference = in_windows(body.fit->rates(0, sensor), begin, window, count);
    if (gyro) {
      constexpr double least_samples = 20;
      for (std::size_t i = 0; i < count; ++i)
        if (std::min(mine.samples[i], reference.samples[i]) >= least_samples) filled.push_back(i);
      for (const std::size_t i : filled)
        result.curve_time.push_back(begin + window * (static_cast<double>(i) + 0.5) + own.offset + 1e-9 * static_cast<double>(between_clocks));
    }
    const Matrix3d to_output = (Matrix3d::Identity() + own.matrix(gyro ? gyro_matrix : accel_matrix)) * own.rotation;
    const Matrix3d& matrix = gyro ? result.calibration.model.gyro.matrix : result.calibration.model.accel.matrix;
    const double sigma = gyro ? own.gyro_sigma : own.accel_sigma, of_reference = gyro ? first.gyro_sigma : first.accel_sigma;
    for (int axis = 0; axis < 3; ++axis) {
      ConvergenceCurve& curve = result.curves.emplace_back();
      curve.name = fmt::format("{}.offset.{}", gyro ? "gyro" : "accel", "xyz"[axis]);
      for (const std::size_t i : filled) {
        const Vector3d change = -matrix * (mine.sum[i] / mine.samples[i] - to_output * (reference.sum[i] / reference.samples[i]));
        curve.residual.push_back(change[axis]);
        curve.sigma.push_back(matrix.row(axis).norm() *
                              std::hypot(sigma / std::sqrt(mine.samples[i]), of_reference / std::sqrt(reference.samples[i])));
      }
    }
  }
}

}  // namespace

CalibrationResult calibrate_by_reference(const CalibrationInput& input, const CalibrationOptions& options) {
  if (!options.reference) throw Error("the method reference lacks its reference; expected the name of the better IMU");
  const Pair pair = pair_of(input, *options.reference);
  kernel::Findings findings;
  const std::vector<BodyImu> imus{pair.reference, pair.other};
  const BodyFit body = fit_body(imus, {.most_used_s = most_used_s, .first_is_reference = true, .progress = options.progress}, findings);
  const ImuState& state = body.fit->states()[1];
  std::vector<CoefficientIndex> all = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  std::erase_if(all, zero_by_frame);

  CalibrationResult result;
  Calibration& c = result.calibration;
  c.method = "reference", c.frame = BodyFrame::accelerometers, c.imu = pair.other.name;
  c.model = model_of(state);
  c.estimated = kernel::chosen_coefficients(options.terms, all, "reference");
  const Index own = MotionFit::mount_column(1) - own_columns;
  const Prior P = body.constants.covariance.block<own_columns, own_columns>(own, own);
  const Prior& before = body.covariance_before[1];
  const Eigen::MatrixXd J = by_errors(state, c.estimated, P.diagonal().cwiseSqrt());
  c.covariance = J * P * J.transpose();
  const Eigen::VectorXd sigma = c.covariance.diagonal().cwiseSqrt(), prior = (J * before * J.transpose()).diagonal().cwiseSqrt();

  Quality& quality = c.quality;
  quality.converged = body.converged;
  // The noise of every sensor is that of its residuals, so the seconds show whether it explains them.
  quality.chi2_per_dof = body.constants.scatter.segment<own_columns>(own).mean();
  quality.degrees_of_freedom = body.constants.seconds;
  quality.condition = kernel::condition_number(c.covariance);
  constexpr double undetermined = 0.7;  // of the prior: the motion tells less than it
  std::vector<std::string> names;
  Calibration determined = c;
  determined.estimated.clear();
  std::vector<Index> places;
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const auto at = static_cast<Index>(k);
    if (sigma[at] > undetermined * prior[at])
      names.emplace_back(coefficient(c.estimated[k]).name);
    else
      determined.estimated.push_back(c.estimated[k]), places.push_back(at);
  }
  determined.covariance = c.covariance(places, places).eval();
  quality.considered = names;
  if (!names.empty())
    findings.add<Code::shown_by_no_motion>(Subject{fmt::format("{}", fmt::join(names, ", "))},
                                           "; shown by turns about all axes, and rests on several faces");
  if (!input.session.imu.grade) findings.add<Code::no_grade>("session");
  if (!pair.reference.calibration) findings.add<Code::imu_not_calibrated>(Subject{pair.reference.name}, "grade " + pair.reference.grade);
  if (options.effects) findings.add<Code::effects_not_estimated>();
  const Mounting mounting = body.mounting(1, imus);
  body.judge_agreement(1, imus, body.fit->rates(1), findings);
  body.judge_scatter(mounting, own, Index{own_columns} + Index{mount_columns}, findings);
  BodyFit::judge_mounting(mounting, findings);
  add_mounting(mounting, quality);
  add_offsets_over_time(body, imus, result);
  if (determined.estimated.empty()) findings.add<Code::no_coefficient_shown>();
  kernel::add_common_doubts(findings, determined, input.session.site);
  kernel::conclude(c, findings);
  return result;
}

}  // namespace imulab::extrinsics
