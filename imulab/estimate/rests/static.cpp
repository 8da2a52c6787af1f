#include "imulab/core/decomposition.hpp"
#include "imulab/earth.hpp"
#include "imulab/estimate/coarse/coarse.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/problem.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

namespace {

using coarse::RestStart;

/// A gyro resolves the Earth's rate if the error of its rest means is below a tenth of it.
constexpr double resolvable_part = 0.1;

/// Cheng's linear gyro solution if the gyros resolve the Earth's rate, else the reason.
struct GyroStart {
  std::optional<coarse::CoarseGyro> coarse;
  std::string reason;
  Code doubt = Code::other;  ///< set if the gyros resolve the rate but contradict it
};

/// Returns the error of the rest means due to sample noise [rad/s], for a matrix of scaled readings.
double mean_noise(const RestStart& start, const Matrix3d& matrix) {
  double worst = 0;
  for (const RestMeans& rest : start.rests)
    worst = std::max(
        worst, (matrix * start.noise.gyro.cwiseQuotient(start.scaling.gyro_scale)).norm() / std::sqrt(3.0 * static_cast<double>(rest.range.size())));
  return worst;
}

/// Returns one sigma of the offset drift of such gyros in a session [rad/s].
double expected_drift(const RestStart& start, const Recording& recording, const Session& session) {
  return kernel::effect_sizes(session, coarse::seen_of(start, recording, session.site.gravity())).of(*find_effect("gyro.drift"));
}

bool has_no_gyros(const Recording& recording) {
  const auto is_silent = [](const std::vector<double>& column) { return std::all_of(column.begin(), column.end(), [](double v) { return v == 0; }); };
  return std::all_of(recording.gyro.begin(), recording.gyro.end(), is_silent);
}

GyroStart start_gyro(const RestStart& start, const Recording& recording, const Session& session, const std::optional<Matrix3d>& unit) {
  const Site& site = session.site;
  const auto not_resolved = [](double error) {
    return GyroStart{{},
                     fmt::format("they do not resolve Earth's rate: noise and drift shift the rests' means by {:.2g} deg/h, more than a tenth of it",
                                 error / unit::deg_per_h)};
  };
  if (has_no_gyros(recording)) return {{}, "the recording has none"};
  const bool counts = recording.gyro_unit == "count";
  if (!site.latitude) return {{}, "the site gives no latitude, and Earth's rate is the gyros' only reference at rest"};
  constexpr double limit = resolvable_part * earth_rate;
  const double noise = unit ? mean_noise(start, *unit) : 0, drift = expected_drift(start, recording, session);
  if (noise > limit) return not_resolved(noise);
  // Headings follow from the horizontal part, which vanishes at a pole.
  if (std::cos(*site.latitude) < resolvable_part) return {{}, "the latitude is too near a pole for the horizontal part of Earth's rate to be seen"};
  const auto coarse = coarse::coarse_gyro_at_rest(start.rests, start.model, start.scaling, earth_rate * std::sin(*site.latitude));
  if (!coarse) return {{}, "twelve or more rests in different directions away from the equator are needed for the gyros"};
  double misfit = 0;  // mean square error of the solution in the size of the Earth's rate
  for (const RestMeans& rest : start.rests)
    misfit += std::pow((coarse->offset + coarse->matrix * start.gyro(rest)).norm() - earth_rate, 2) / static_cast<double>(start.rests.size());
  const double by_noise = mean_noise(start, coarse->matrix), error = std::max(by_noise, std::sqrt(misfit));
  const bool resolve = unit && drift <= limit;
  constexpr double many = 3;  // in sigmas
  if (error > limit && !(resolve && error > many * std::hypot(noise, drift))) return not_resolved(std::max(by_noise, drift));
  if (error > limit)
    return {{},
            fmt::format("the rests' means miss Earth's rate by {:.2g} deg/h, where their noise explains {:.2g}", error / unit::deg_per_h,
                        noise / unit::deg_per_h),
            Code::gyros_change};
  if (!counts && !coarse::near_identity(coarse->matrix))
    return {{},
            "their readings at rest do not agree with the Earth's rate in rad/s; check the latitude (and its sign), the axes and the unit",
            resolve ? Code::not_earth_rate : Code::other};
  return {coarse, {}};
}

/// Returns true if the rest means of otherwise unchecked gyros have a step that force, noise and drift do not explain: they were zeroed or switched
/// to another range. `unit`: matrix of scaled readings.
bool output_steps(const RestStart& start, const Matrix3d& unit, double drift) {
  constexpr double many = 5, most_left = 1.0 / 9;  // in sigmas; fraction of the squares: motion of a hand and warming cause no step
  constexpr Eigen::Index enough = 4;               // rests on either side, as many as unknowns
  const auto n = std::ssize(start.rests);
  Eigen::MatrixXd by_force(n, 4), means(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const RestMeans& rest = start.rests[static_cast<std::size_t>(k)];
    by_force.row(k) << 1, start.up(rest).transpose();
    means.row(k) = (unit * start.gyro(rest)).transpose();
  }
  if (n < 2 * enough) return false;
  const Eigen::MatrixXd Q = orthogonal_triangular(by_force).Q, left = means - Q * (Q.transpose() * means);
  const double squares = left.squaredNorm(), scatter = std::sqrt(squares / (3.0 * static_cast<double>(n - 4)));
  if (!(scatter > many * std::hypot(mean_noise(start, unit), drift, earth_rate))) return false;
  double explained = 0;
  for (Eigen::Index k = enough; k + enough <= n; ++k) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    step.tail(n - k).setOnes();
    step -= Q * (Q.transpose() * step);
    explained = std::max(explained, (step.transpose() * left).squaredNorm() / step.squaredNorm());
  }
  return squares - explained < most_left * squares;
}

}  // namespace

bool start_gyros_at_rest(RestStart& start, const Recording& recording, const Session& session) {
  const std::optional<Matrix3d> unit = recording.gyro_unit != "count"
                                           ? Matrix3d(Matrix3d::Identity())
                                           : coarse::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  GyroStart gyro = start_gyro(start, recording, session, unit);
  if (gyro.coarse) {
    start.model.gyro.offset = gyro.coarse->offset;
    start.model.gyro.matrix = gyro.coarse->matrix;
    if (recording.gyro_unit == "count") start.prior.gyro = start.model.gyro;
    coarse::use_declared_gyro_noise(start, recording, session.imu);
    return true;
  }
  // The scaled model must convert to the starting value one for raw readings.
  SensorModel as_read;
  as_read.gyro.raw_unit = recording.gyro_unit;
  start.model.gyro = to_scaled(as_read, start.scaling).gyro;
  if (has_no_gyros(recording)) {
    start.findings.add<Code::gyros_not_calibrated>(gyro.reason).severity = Severity::note;
    return false;
  }
  if (recording.gyro_unit == "count") gyro.reason += "; they stay in counts";
  start.findings.add<Code::gyros_not_calibrated>(gyro.reason);
  if (gyro.doubt == Code::other && unit && output_steps(start, *unit, expected_drift(start, recording, session))) gyro.doubt = Code::gyros_change;
  if (gyro.doubt == Code::gyros_change) start.findings.add<Code::gyros_change>();
  if (gyro.doubt == Code::not_earth_rate) start.findings.add<Code::not_earth_rate>();
  return false;
}

namespace {

/// Rests alone do not reveal reversed or swapped accelerometer axes. Gyros with orthogonal axes in the motion between rests do.
void check_axes(RestStart& start, const Recording& recording) {
  const auto in_motion = coarse::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0) || kernel::is_oblique(*in_motion)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty()) start.findings.add<Code::axes_against_gravity>(wrong);
}

/// At rest, gyros that are all reversed measure the Earth's rate of the other hemisphere. Between the rests they turn opposite to gravity.
void check_turns(RestStart& start, const Recording& recording, const Matrix3d& gyro) {
  constexpr double least = 0.5;  // as for gyros that turn with the accelerometers; calibrated gyros explain nearly all of the turning
  const auto explained = coarse::explained_turning(recording, start, gyro);
  if (!explained || *explained > least) return;
  const bool reversed = coarse::explained_turning(recording, start, -gyro).value_or(0) > least;
  if (reversed)
    start.findings.add<Code::latitude_by_turns>(), start.findings.add<Code::wrong_latitude>();
  else
    start.findings.add<Code::gyros_do_not_carry_gravity>(), start.findings.add<Code::gyros_against_gravity>();
}

}  // namespace

CalibrationResult calibrate_static(const CalibrationInput& input, const CalibrationOptions& options) {
  RestStart start = coarse::start_from_rests(input, "static");
  const Recording& recording = input.recordings.front();
  if (options.terms.empty() && sweeps_in_one_attitude(start, recording)) return calibrate_with_links(input, options, "static", std::move(start));
  const Session& session = input.session;
  const bool with_gyros = start_gyros_at_rest(start, recording, session);
  check_axes(start, recording);
  const std::vector<CoefficientIndex> indices =
      choose_coefficients(start, session, recording, options.effects, options.terms, static_coefficients(with_gyros), "static");

  auto cleaned = kernel::drop_suspects(SuspectFit(StaticProblem(start, session.site, indices, with_gyros)), options.outlier_level);
  StaticProblem& problem = cleaned.fit.problem;
  const Fit fit = fit_determined(problem, std::move(cleaned.fit.fit));
  if (with_gyros) check_turns(start, recording, problem.model().gyro.matrix);

  CalibrationResult result{.calibration = calibration_of("static", problem, fit, session)};
  add_parts(result.calibration.quality, problem.suspects(fit.conditions), fit, cleaned.fit.dropped);
  result.calibration.quality.term_tests = test_terms(problem, fit, options.significance);
  start.findings.add<Code::parts_used>(fmt::format("{} rests", problem.rests().size())).numbers = {static_cast<double>(problem.rests().size())};
  add_findings(start.findings, result.calibration, problem, fit, curvature(problem, fit), session.site, cleaned.dropped, start.rests.size());
  kernel::add_effects(result.calibration, start.findings, problem.effects(), fit.covariance(), 1e-3, problem.indices());
  kernel::conclude(result.calibration, start.findings);
  return result;
}

}  // namespace imulab::rests
