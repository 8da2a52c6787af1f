#include "imulab/earth.hpp"
#include "imulab/estimate/coarse/coarse.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/fit.hpp"
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

/// A gyro resolves Earth's rate if its rest means are good to a tenth of it.
constexpr double resolvable_part = 0.1;

/// Cheng's linear gyro solution where the gyros resolve Earth's rate; else why not.
struct GyroStart {
  std::optional<coarse::CoarseGyro> coarse;
  std::string reason;
};

/// The error of the rests' means from the samples' noise [rad/s], with a matrix of scaled readings.
double mean_noise(const RestStart& start, const Matrix3d& matrix) {
  double worst = 0;
  for (const RestMeans& rest : start.rests)
    worst = std::max(
        worst, (matrix * start.noise.gyro.cwiseQuotient(start.scaling.gyro_scale)).norm() / std::sqrt(3.0 * static_cast<double>(rest.range.size())));
  return worst;
}

GyroStart start_gyro(const RestStart& start, const Recording& recording, const Site& site) {
  const auto not_resolved = [](double error) {
    return GyroStart{
        {},
        fmt::format("they do not resolve Earth's rate: the rests' means miss it by {:.2g} deg/h, more than a tenth of it", error / unit::deg_per_h)};
  };
  const auto is_silent = [](const std::vector<double>& column) { return std::all_of(column.begin(), column.end(), [](double v) { return v == 0; }); };
  if (std::all_of(recording.gyro.begin(), recording.gyro.end(), is_silent)) return {{}, "the recording has none"};
  const bool counts = recording.gyro_unit == "count";
  if (!site.latitude) return {{}, "the site gives no latitude, and Earth's rate is the gyros' only reference at rest"};
  if (const double noise = mean_noise(start, Matrix3d::Identity()); !counts && noise > resolvable_part * earth_rate) return not_resolved(noise);
  // The headings are found from the horizontal part, which vanishes at a pole.
  if (std::cos(*site.latitude) < resolvable_part) return {{}, "the latitude is too near a pole for the horizontal part of Earth's rate to be seen"};
  const auto coarse = coarse::coarse_gyro_at_rest(start.rests, start.model, start.scaling, earth_rate * std::sin(*site.latitude));
  if (!coarse) return {{}, "twelve or more rests in different directions away from the equator are needed for the gyros"};
  if (!counts && !coarse::near_identity(coarse->matrix))
    return {{}, "their readings at rest do not agree with the Earth's rate in rad/s; check the latitude (and its sign), the axes and the unit"};
  double misfit = 0;  // mean square of what the solution misses of the size of Earth's rate
  for (const RestMeans& rest : start.rests)
    misfit += std::pow((coarse->offset + coarse->matrix * start.gyro(rest)).norm() - earth_rate, 2) / static_cast<double>(start.rests.size());
  const double error = std::max(mean_noise(start, coarse->matrix), std::sqrt(misfit));
  return error > resolvable_part * earth_rate ? not_resolved(error) : GyroStart{coarse, {}};
}

}  // namespace

bool start_gyros_at_rest(RestStart& start, const Recording& recording, const Session& session) {
  const GyroStart gyro = start_gyro(start, recording, session.site);
  if (gyro.coarse) {
    start.model.gyro.offset = gyro.coarse->offset;
    start.model.gyro.matrix = gyro.coarse->matrix;
    if (recording.gyro_unit == "count") start.prior.gyro = start.model.gyro;
    coarse::use_declared_gyro_noise(start, recording, session.imu);
  } else {
    // The scaled model must give back the starting value, one, when it returns to raw readings.
    SensorModel unit;
    unit.gyro.raw_unit = recording.gyro_unit;
    start.model.gyro = to_scaled(unit, start.scaling).gyro;
    start.findings.note("the gyros were not calibrated: " + gyro.reason);
  }
  return gyro.coarse.has_value();
}

namespace {

/// Rests alone do not tell a reversed or swapped axis. The gyros do, where the motion between the rests shows theirs at right angles.
void check_axes(RestStart& start, const Recording& recording) {
  const auto in_motion = coarse::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0) || kernel::is_oblique(*in_motion)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty())
    start.findings.doubt(wrong + ", as gravity turns in the IMU; check the order and the signs of both triads' columns");
}

}  // namespace

CalibrationResult calibrate_static(const CalibrationInput& input, const CalibrationOptions& options) {
  RestStart start = coarse::start_from_rests(input, "static");
  const Recording& recording = input.recordings.front();
  const Session& session = input.session;
  const bool with_gyros = start_gyros_at_rest(start, recording, session);
  check_axes(start, recording);
  const std::vector<CoefficientIndex> indices =
      choose_coefficients(start, session, recording, options.effects, options.terms, static_coefficients(with_gyros), "static");

  auto cleaned = kernel::drop_suspects(SuspectFit(StaticProblem(start, session.site, indices, with_gyros)), options.outlier_level);
  StaticProblem& problem = cleaned.fit.problem;
  const Fit fit = fit_determined(problem);

  CalibrationResult result{.calibration = calibration_of("static", problem, fit, session)};
  add_parts(result.calibration.quality, problem.suspects(fit.conditions), fit, cleaned.fit.dropped);
  result.calibration.quality.term_tests = test_terms(problem, fit, options.significance);
  start.findings.note(fmt::format("{} rests were used", problem.rests().size()));
  add_findings(start.findings, result.calibration, problem, fit, curvature(problem, fit), session.site, cleaned.dropped, start.rests.size());
  kernel::add_effects(result.calibration, start.findings, problem.effects(), fit.covariance(), 1e-3, problem.indices());
  kernel::conclude(result.calibration, start.findings);
  return result;
}

}  // namespace imulab::rests
