#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/common_turns.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/advice.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/rests.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab::rests {

namespace {

using Eigen::Index;
using kernel::RestStart;

bool near_diagonal(const Matrix3d& matrix) {
  return (matrix.rowwise().norm() - matrix.diagonal().cwiseAbs()).cwiseQuotient(matrix.rowwise().norm()).maxCoeff() < 0.1;
}

/// Axes may be swapped or turned, but gyros in SI are as long as declared and at right angles. Motion about too few axes gives any matrix.
bool possible(const Matrix3d& matrix) {
  const Vector3d lengths = singular_values(matrix).values;
  return lengths.minCoeff() > 0.8 && lengths.maxCoeff() < 1.2;  // 20 % as elsewhere: scales are off by a few percent
}

/// Gyro offset and matrix for the start: from the motion where it determines them, else as the declared unit says. Turns of a declared angle tell
/// whether it is as declared better than fast motion of a hand does.
void start_gyro(RestStart& start, const Recording& recording, bool declared_turns) {
  const bool counts = recording.gyro_unit == "count";
  std::optional<Matrix3d> coarse = kernel::coarse_gyro_in_common_turns(recording, start);
  if (!counts && declared_turns) coarse.reset();
  TriadModel& gyro = start.model.gyro;
  if (coarse) gyro.matrix = *coarse;
  if (!coarse && counts)
    throw Unsupported(fmt::format(
        "{}: the motion between the rests does not turn the IMU about all three axes: the gyros' scales cannot be determined", recording.name));
  if (!counts && coarse) kernel::expect_gyro_scale(*coarse, recording);
  if (!counts && !possible(gyro.matrix)) gyro.matrix.setIdentity();
  gyro.offset = -gyro.matrix * start.scaling.gyro(mean_gyro(start.rests));
  // Axes that are not as declared (swapped, turned) and counts have no better prior than the coarse solution itself.
  if (counts) {
    start.prior.gyro.offset = gyro.offset;
    start.prior.gyro.matrix = near_diagonal(gyro.matrix) ? Matrix3d(gyro.matrix.diagonal().asDiagonal()) : gyro.matrix;
  } else if (!kernel::near_identity(gyro.matrix)) {
    start.prior.gyro.matrix = gyro.matrix;
  }
}

/// Gravity as the gyros carry it across a rotation against gravity as it is found after it, each tenth of the rotations predicted without it.
/// Rotations of less than 10 deg do not count: any gyro would predict them well.
struct CrossValidation {
  double rms_deg = 0;
  std::size_t rotations = 0;
};

CrossValidation cross_validate(const HandheldProblem& problem, const Fit& fit) {
  std::vector<HandheldProblem::RotationRows> rotations = problem.rotation_rows(fit.conditions);
  std::erase_if(rotations, [](const auto& rotation) { return !(rotation.angle > 10 * unit::deg); });
  const std::size_t folds = std::min<std::size_t>(10, rotations.size());
  double squares = 0;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    Conditions held_out = fit.conditions;
    for (std::size_t i = fold; i < rotations.size(); i += folds)
      held_out.blocks[rotations[i].block].covariance.diagonal().tail(held_out.blocks[rotations[i].block].size - 4) *= 1e10;  // no weight
    const Eigen::VectorXd residual = adjust(held_out, fit.parameters).residual;
    for (std::size_t i = fold; i < rotations.size(); i += folds) squares += residual.segment<2>(rotations[i].first).squaredNorm();
  }
  return {std::sqrt(squares / static_cast<double>(std::max<std::size_t>(rotations.size(), 1))) / unit::deg, rotations.size()};
}

void add_turns(kernel::Findings& findings, const std::vector<Step>& steps, const std::vector<DeclaredTurn>& turns, std::size_t usable,
               const HandheldProblem& problem) {
  if (turns.empty()) {
    const auto rotates = [](const Step& step) { return step.kind == StepKind::rotate; };
    if (std::any_of(steps.begin(), steps.end(), rotates))
      findings.warn("turns are declared, but not how well their angles are known: they are not used; declare the sigma of the rig's angles");
    return;
  }
  findings.note(fmt::format("{} of {} turns were used with their declared angle, each known to {:.2g} deg", problem.turns(), turns.size(),
                            turns.front().angle_sigma() / unit::deg));
  if (usable < turns.size())
    findings.warn(fmt::format("{} of {} turns have no rest of their own before and after them, or a gap: their angle is not used",
                              turns.size() - usable, turns.size()));
  if (problem.turns(true) > 0) findings.doubt("a turn does not fit its declared angle");
}

}  // namespace

CalibrationResult calibrate_handheld(const CalibrationInput& input, const CalibrationOptions& options) {
  RestStart start = kernel::start_from_rests(input, "handheld");
  const Recording& recording = input.recordings.front();
  const Session& session = input.session;
  kernel::expect_alive(recording, Triad::gyro, "the method static calibrates the accelerometers alone");
  const std::vector<DeclaredTurn> turns = declared_turns(session, session.source_of(recording.name));
  start_gyro(start, recording, !turns.empty());
  kernel::use_declared_gyro_noise(start, recording, session.imu);
  const std::vector<CoefficientIndex> indices = choose_coefficients(start, session, options.terms, handheld_coefficients(), "handheld");

  HandheldProblem whole(recording, start, session.site, indices, turns);
  const std::size_t usable_turns = whole.turns(), parts = start.rests.size() + whole.rotations();
  auto cleaned = kernel::drop_suspects(SuspectFit(std::move(whole)), options.outlier_level);
  cleaned.fit.next.reset(), cleaned.fit.fit = {};  // each as large as the fit that follows
  HandheldProblem& problem = cleaned.fit.problem;
  const Fit fit = fit_determined(problem);

  CalibrationResult result{.calibration = calibration_of("handheld", problem, fit, session)};
  Quality& quality = result.calibration.quality;
  add_parts(quality, problem.suspects(fit.conditions), fit, cleaned.fit.dropped);
  quality.term_tests = test_terms(problem, fit, options.significance);
  kernel::Findings& findings = start.findings;
  findings.note(fmt::format("{} rests and {} rotations between them were used", problem.rests().size(), problem.rotations()));
  add_turns(findings, session.steps, turns, usable_turns, problem);
  if (const CrossValidation check = cross_validate(problem, fit); check.rotations >= 10) {  // a tenth of fewer is not a rotation
    quality.rotation_residual_deg = check.rms_deg;
    findings.note(fmt::format("held-out rotations are predicted to {:.3f} deg RMS (10-fold cross-validation over {} rotations of more than 10 deg)",
                              check.rms_deg, check.rotations));
  }
  if (!session.site.latitude) findings.note("no latitude: Earth's rate is unknown but for its size (15 deg/h); the gyros' uncertainties contain it");
  add_findings(findings, result.calibration, problem, fit, curvature(problem, fit), session.site, cleaned.dropped, parts);
  if (session.site.latitude) kernel::doubt_latitude(findings, result.calibration, *session.site.latitude, session.site.gravity());
  // An uncalibrated gyro of 2 % predicts turns of a right angle to about 1 deg.
  if (quality.rotation_residual_deg.value_or(0) > 1)
    findings.doubt(fmt::format("held-out rotations are predicted no better than to {:.2g} deg", *quality.rotation_residual_deg));
  kernel::conclude(result.calibration, findings);
  result.missing_turns = next_turns(problem, fit, options.handheld);
  return result;
}

}  // namespace imulab::rests
