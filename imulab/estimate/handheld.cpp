#include "imulab/estimate/handheld.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/coarse.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/handheld_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;

namespace {

std::vector<int> supplied_coefficients() {
  std::vector<int> indices = accel_coefficients();
  for (const char* selector : {"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

bool near_diagonal(const Matrix3d& matrix) {
  return (matrix.rowwise().norm() - matrix.diagonal().cwiseAbs()).cwiseQuotient(matrix.rowwise().norm()).maxCoeff() < 0.1;
}

/// Gyro offset and matrix for the start: from the motion where it tells, else as the declared unit says.
void start_gyro(Start& start, const Recording& recording) {
  Vector3d at_rest = Vector3d::Zero();
  for (const Rest& rest : start.rests) at_rest += rest.gyro / static_cast<double>(start.rests.size());
  const auto coarse = coarse_gyro_in_motion(recording, start.rests, start.scaled_model, start.scaling);
  TriadModel& gyro = start.scaled_model.gyro;
  if (coarse) {
    gyro.matrix = *coarse;
    if (recording.gyro_unit != "count") {
      // A unit mistaken: rad/s read as deg/s or the reverse. Uncalibrated scales are within 20 %.
      const double scale = std::cbrt(std::abs(coarse->determinant()));
      const auto near = [&](double expected) { return std::abs(scale / expected - 1) < 0.2; };
      const auto mistaken = [&](const char* looks) {
        return Error(fmt::format("{}: gyro: the rotations between the rests are {:.3g} times what the readings say with the declared unit {}: they look like {}",
                                 recording.name, scale, recording.gyro_unit, looks));
      };
      if (near(unit::deg)) throw mistaken("deg/s");
      if (near(1 / unit::deg)) throw mistaken("rad/s");
    }
  } else if (recording.gyro_unit == "count") {
    throw Unsupported(fmt::format("{}: the motion between the rests does not turn the unit about all three axes: the gyros' scales cannot be determined", recording.name));
  }
  gyro.offset = -gyro.matrix * (at_rest - start.scaling.gyro_center).cwiseQuotient(start.scaling.gyro_scale);
  // Axes that are not as declared (swapped, turned) and counts have no better prior than the coarse solution itself.
  if (recording.gyro_unit == "count") {
    start.prior.mean.gyro.offset = gyro.offset;
    start.prior.mean.gyro.matrix = near_diagonal(gyro.matrix) ? Matrix3d(gyro.matrix.diagonal().asDiagonal()) : gyro.matrix;
  } else if (!near_identity(gyro.matrix)) {
    start.prior.mean.gyro.matrix = gyro.matrix;
  }
}

/// Gyros and accelerometers that do not turn together: columns swapped, or a sign. The calibration is right for the readings as they are.
void warn_of_other_axes(const SensorModel& model, std::vector<std::string>& warnings) {
  for (Index row = 0; row < 3; ++row) {
    Index column = 0;
    model.gyro.matrix.row(row).cwiseAbs().maxCoeff(&column);
    if (column == row && model.gyro.matrix(row, row) > 0) continue;
    warnings.push_back(fmt::format("the rate about the accelerometers' {} axis is the gyros' {}{} reading: are the columns and signs right?",
                                   "xyz"[row], model.gyro.matrix(row, column) < 0 ? "-" : "", "xyz"[column]));
  }
}

/// Wald test of a term's coefficients against zero.
TermTest test_term(std::string_view term, const HandheldProblem& problem, const Fit& fit, double significance) {
  std::vector<Index> at;
  for (const int index : select_coefficients(term)) {
    const auto found = std::find(problem.indices().begin(), problem.indices().end(), index);
    const auto i = found - problem.indices().begin();
    if (found != problem.indices().end() && fit.adjustment.determined[static_cast<std::size_t>(i)]) at.push_back(i);
  }
  TermTest test{std::string(term), 0, static_cast<int>(at.size()), 1, false};
  if (at.empty()) return test;
  Eigen::VectorXd value(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) value[static_cast<Index>(i)] = coefficient_value(problem.scaled_model(), problem.indices()[static_cast<std::size_t>(at[i])]);
  test.statistic = value.dot(Eigen::MatrixXd(fit.adjustment.covariance(at, at)).ldlt().solve(value));
  test.p_value = chi_square_tail(test.statistic, test.degrees_of_freedom);
  test.kept = test.p_value <= significance;
  return test;
}

/// Gravity as the gyros carry it across a rotation against gravity as it is found after it, each tenth of the rotations predicted without it. Rotations
/// of less than 10 deg count for nothing: they would be predicted well by any gyro.
struct CrossValidation {
  double rms_deg = 0;
  std::size_t rotations = 0;
};

CrossValidation cross_validate(const HandheldProblem& problem, const Fit& fit) {
  std::vector<std::array<Index, 2>> rotations;
  for (const auto& rotation : problem.rotation_rows(fit.conditions))
    if (rotation.angle > 10 * unit::deg) rotations.push_back(rotation.rows);
  const std::size_t folds = std::min<std::size_t>(10, rotations.size());
  double squares = 0;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    Conditions held_out = fit.conditions;
    for (Conditions::Block& block : held_out.blocks)
      for (std::size_t i = fold; i < rotations.size(); i += folds)
        for (const Index row : rotations[i])
          if (row >= block.first && row < block.first + block.size) block.covariance(row - block.first, row - block.first) *= 1e10;  // no weight
    const Adjustment without = adjust(held_out, problem.prior_sigma());
    for (std::size_t i = fold; i < rotations.size(); i += folds)
      for (const Index row : rotations[i]) squares += without.residual[row] * without.residual[row];
  }
  return {std::sqrt(squares / static_cast<double>(std::max<std::size_t>(rotations.size(), 1))) / unit::deg, rotations.size()};
}

}  // namespace

Calibration calibrate_handheld(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, const Site& site,
                               const EstimateOptions& options) {
  Start start = start_from_rests(recording, ranges, imu, site.gravity());
  expect_alive(recording.gyro, recording.name, "gyro", "the method static calibrates the accelerometers alone");
  start_gyro(start, recording);
  use_declared_gyro_noise(start, recording, imu);

  const std::vector<int> supplied = supplied_coefficients();
  const std::vector<int> indices = options.terms.empty() ? supplied : choose_terms(options.terms, supplied, "handheld");
  keep_start_of_others(start, indices, supplied);
  HandheldProblem problem(recording, start.rests, site.gravity(), site.latitude, start.noise, start.scaling, start.scaled_model, start.prior, indices);
  const std::size_t all = start.rests.size() + problem.rotations();
  const std::vector<std::string> dropped = drop_outliers(problem, options.outlier_level);
  Fit fit = converge(problem);

  std::vector<TermTest> tests;
  if (options.terms.empty()) {
    tests.push_back(test_term("gyro.g_sensitivity", problem, fit, options.significance));
    if (!tests.back().kept) {
      std::vector<int> fewer = problem.indices();
      const std::vector<int> term = select_coefficients("gyro.g_sensitivity");
      std::erase_if(fewer, [&](int index) { return std::find(term.begin(), term.end(), index) != term.end(); });
      problem.estimate_only(fewer);
    }
  }
  fit = settle(problem);

  Calibration calibration = finish("handheld", start, fit, problem.scaled_model(), problem.indices(), imu, site);
  Quality& quality = calibration.quality;
  quality.term_tests = tests;
  warn_of_other_axes(calibration.model, quality.warnings);
  const Conditions noise_only = problem.conditions({});
  const Adjustment under_noise = adjust(noise_only, problem.prior_sigma());
  quality.degrees_of_freedom = static_cast<int>(std::lround(under_noise.degrees_of_freedom));
  quality.chi2_per_dof = under_noise.chi2 / std::max(1.0, under_noise.degrees_of_freedom);
  quality.notes.push_back(fmt::format("{} rests and {} rotations between them were used", problem.rests().size(), problem.rotations()));
  if (const CrossValidation check = cross_validate(problem, fit); check.rotations >= 10) {  // of fewer a tenth is not a rotation
    quality.rotation_residual_deg = check.rms_deg;
    quality.notes.push_back(fmt::format("rotations are predicted to {:.3f} deg RMS (10-fold cross-validation over {} rotations of more than 10 deg)", check.rms_deg,
                                        check.rotations));
  }
  if (fit.spreads[0] > 0) quality.notes.push_back(spread_note("the rests' accelerometer means", fit.spreads[0] / unit::ug, "ug"));
  if (fit.spreads[1] > 0) quality.notes.push_back(spread_note("the rests' gyro means", fit.spreads[1] / unit::deg_per_h, "deg/h"));
  if (fit.spreads[2] > 0) quality.notes.push_back(spread_note("the rotations", fit.spreads[2] / unit::deg, "deg"));
  for (const std::string& name : dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  if (!site.latitude) quality.notes.push_back("no latitude: Earth's rate was taken as unknown up to its size (15 deg/h) and is counted in the gyros' uncertainties");

  std::vector<std::string> doubts = common_doubts(calibration, fit, site, dropped.size(), all);
  // An uncalibrated gyro of 2 % predicts turns of a right angle to about 1 deg.
  if (quality.rotation_residual_deg.value_or(0) > 1) doubts.push_back(fmt::format("the rotations are predicted no better than to {:.2g} deg", *quality.rotation_residual_deg));
  conclude(calibration, doubts);
  return calibration;
}

}  // namespace imulab
