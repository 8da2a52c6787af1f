#include "imulab/estimate/turntable.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/turntable_estimator.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double chance = 1e-3;  // what happens less often by chance is said

/// Table indices of the terms the method supplies.
std::vector<int> supplied_coefficients() {
  std::vector<int> indices;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

/// The forward model keeps a matrix whole or diagonal, and the other terms whole.
std::vector<int> chosen_coefficients(const std::vector<int>& wanted) {
  const std::vector<int> chosen = choose_terms(wanted, supplied_coefficients(), "turntable");
  const auto part = [&](const char* selector) {
    const std::vector<int> all = select_coefficients(selector);
    const auto found = std::count_if(all.begin(), all.end(), [&](int i) { return std::find(chosen.begin(), chosen.end(), i) != chosen.end(); });
    return std::pair{found, static_cast<std::ptrdiff_t>(all.size())};
  };
  for (const char* triad : {"accel", "gyro"}) {
    const auto [off, all_off] = part(fmt::format("{}.matrix.off_diagonal", triad).c_str());
    const auto [diagonal, all_diagonal] = part(fmt::format("{}.matrix.diagonal", triad).c_str());
    if ((diagonal != 0 && diagonal != all_diagonal) || (off != 0 && off != all_off) || (off > 0 && diagonal == 0))
      throw Error(fmt::format("--terms: of {0}.matrix the method turntable estimates all, or {0}.matrix.diagonal, or none", triad));
  }
  for (const char* term : {"accel.offset", "gyro.offset", "gyro.g_sensitivity"})
    if (const auto [found, all] = part(term); found != 0 && found != all)
      throw Error(fmt::format("--terms: the method turntable estimates all of {} or none", term));
  return chosen;
}

std::vector<int> without_g_sensitivity(std::vector<int> terms) {
  std::erase_if(terms, [](int index) { return coefficient_table()[static_cast<std::size_t>(index)].term == Term::g_sensitivity; });
  return terms;
}

/// Root mean square of what varies in three rows of every part from `first` on.
double spread(const VectorXd& v, const std::vector<Index>& at, bool about_mean) {
  Vector3d mean = Vector3d::Zero();
  if (about_mean)
    for (const Index row : at) mean += v.segment<3>(row) / static_cast<double>(at.size());
  double squares = 0;
  for (const Index row : at) squares += (v.segment<3>(row) - mean).squaredNorm();
  return std::sqrt(squares);
}

/// Readings in counts start from the size of what they read; SI readings from themselves.
SensorModel starting_model(const TableObservations& seen, const TableMotion& motion) {
  const VectorXd truth = motion.truth(motion.nominal()), values = seen.values();
  const auto holds = static_cast<Index>(motion.holds());
  std::vector<Index> force, turn_truth, turn_sum;
  for (Index k = 0; k < holds; ++k) force.push_back(6 * k);
  for (Index k = 0; k < static_cast<Index>(motion.turns()); ++k) {
    turn_truth.push_back(6 * (holds + k));
    turn_sum.push_back(6 * holds + 3 * k);
  }
  SensorModel start;
  if (seen.accel_counts && spread(truth, force, true) > 0 && spread(values, force, true) > 0)
    start.accel.matrix *= spread(truth, force, true) / spread(values, force, true);
  if (seen.gyro_counts && turn_sum.size() > 1 && spread(values, turn_sum, true) > 0)
    start.gyro.matrix *= spread(truth, turn_truth, true) / spread(values, turn_sum, true);
  return start;
}

/// The noise declared, or as the holds' samples show it; a stuck or coarsely quantised axis shows none, and a hundred-millionth of the scale keeps
/// the weights finite.
RawNoise raw_noise(const TableObservations& seen, const SensorModel& model, const ImuDeclaration& imu) {
  const auto measured = [](const Vector3d& density, const Matrix3d& matrix, double size) {
    return Matrix3d(density.cwiseMax(1e-8 * size / std::cbrt(std::abs(matrix.determinant()))).cwiseAbs2().asDiagonal());
  };
  return {
      imu.accel_noise_density ? raw_density(*imu.accel_noise_density, model.accel.matrix) : measured(seen.accel_density, model.accel.matrix, unit::g),
      imu.gyro_noise_density ? raw_density(*imu.gyro_noise_density, model.gyro.matrix) : measured(seen.gyro_density, model.gyro.matrix, 1.0)};
}

struct Problem {
  const TableObservations& seen;
  const TableMotion& motion;
  const ImuDeclaration& imu;
  VectorXd values;
};

struct Solution {
  TurntableEstimator estimator;
  VectorXd readings;  ///< linearised
  SensorModel model;
  double chi2;
  double log_probability() const { return log_chi_square_tail(chi2, std::max(1, estimator.degrees_of_freedom())); }
};

/// Sensors' noise alone sets the first weights; then the table's errors are brought to raw readings with the model found, and the motion is linear
/// about the table errors found.
Solution solve(const Problem& problem, TurntableSettings settings) {
  SensorModel model = starting_model(problem.seen, problem.motion);
  settings.table_errors = false;
  model = TurntableEstimator(problem.motion, model, raw_noise(problem.seen, model, problem.imu), settings).estimate(problem.values);
  settings.table_errors = true;
  const auto usable = [](const SensorModel& m) {
    return m.accel.matrix.allFinite() && m.gyro.matrix.allFinite() && m.accel.matrix.determinant() != 0 && m.gyro.matrix.determinant() != 0;
  };
  for (int pass = 0;; ++pass) {
    if (!usable(model)) throw Unsupported("the readings do not follow the table's motion: a triad's readings do not span three axes");
    TurntableEstimator estimator(problem.motion, model, raw_noise(problem.seen, model, problem.imu), settings);
    const VectorXd readings = estimator.linearised(problem.values);
    model = estimator.estimate(readings);
    if (pass == 1) return {estimator, readings, model, estimator.chi2(readings)};
    settings.around = estimator.table_errors(readings);
  }
}

/// A declared unit mistaken for another: the scale then is that of the other unit. Uncalibrated scales are within 20 %.
void check_units(const TableObservations& seen, const SensorModel& model) {
  const double accel = std::cbrt(std::abs(model.accel.matrix.determinant())), gyro = std::cbrt(std::abs(model.gyro.matrix.determinant()));
  const auto near = [](double value, double expected) { return std::abs(value / expected - 1) < 0.2; };
  const auto mistaken = [](const char* triad, double scale, const char* looks) {
    return Error(fmt::format(
        "{0}: the table's motion is {1:.3g} times what the readings say with the declared unit: they look like {2}; declare unit = \"{2}\"", triad,
        scale, looks));
  };
  if (!seen.accel_counts && near(accel, unit::g)) throw mistaken("accel", accel, "g");
  if (!seen.accel_counts && near(accel, 1 / unit::g)) throw mistaken("accel", accel, "m/s^2");
  if (!seen.gyro_counts && near(gyro, unit::deg)) throw mistaken("gyro", gyro, "deg/s");
  if (!seen.gyro_counts && near(gyro, 1 / unit::deg)) throw mistaken("gyro", gyro, "rad/s");
}

bool left_handed(const SensorModel& model) { return model.accel.matrix.determinant() < 0 || model.gyro.matrix.determinant() < 0; }

/// The steps with the sense of one axis reversed.
TableObservations reversed(TableObservations seen, std::size_t axis) {
  for (Step& step : seen.steps) {
    step.angles[axis] = -step.angles[axis];
    if (step.kind == StepKind::rotate && static_cast<std::size_t>(step.axis) == axis) step.angle = -step.angle;
  }
  return seen;
}

/// Where the readings contradict the steps: do they fit with one axis turning the other way? Empty if not.
std::string reversed_axis(const Problem& problem, const Solution& solution, const RigDeclaration& rig, const Site& site,
                          const TurntableSettings& settings) {
  const bool mirrored = left_handed(solution.model);
  if (!mirrored && solution.log_probability() > std::log(chance)) return {};
  std::string found;
  double best = solution.chi2 + (mirrored ? 30.0 : -30.0);  // a few sigmas of doubt where handedness speaks for it, against it where not
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const TableObservations seen = reversed(problem.seen, axis);
    const TableMotion motion(seen, rig, site);
    const Solution other = solve({seen, motion, problem.imu, problem.values}, settings);
    if (left_handed(other.model) || other.chi2 >= best) continue;
    best = other.chi2;
    found = fmt::format("the {} axis seems to turn against the sign of its angles: with it reversed chi-square falls from {:.4g} to {:.4g}",
                        to_string(static_cast<RigAxis>(axis)), solution.chi2, other.chi2);
    if (mirrored) found += ", and the sensors' axes become right-handed";
  }
  if (found.empty() && mirrored) found = "a triad is left-handed in the table's axes: a sensor's or a table axis's sign is reversed";
  return found;
}

/// Leaves steps out one by one, the least probable first, if that makes the others agree; if not, the noise or the table is worse than declared.
struct Cleaned {
  Solution solution;
  std::vector<std::string> dropped;
  std::string worst;  ///< the least probable step where leaving out does not help
};

Cleaned drop_outliers(const Problem& problem, Solution solution, TurntableSettings& settings, double level) {
  const std::size_t parts = problem.motion.holds() + problem.motion.turns();
  const TurntableSettings before = settings;
  Cleaned cleaned{solution, {}, {}};
  while (true) {
    const std::vector<double> log_p = cleaned.solution.estimator.log_probabilities(cleaned.solution.readings);
    const auto least = std::min_element(log_p.begin(), log_p.end());
    if (least == log_p.end() || *least > std::log(level / static_cast<double>(parts))) break;
    const auto part = static_cast<std::size_t>(least - log_p.begin());
    const std::string name = describe_step(problem.seen.steps, problem.motion.step(part));
    if (cleaned.worst.empty()) cleaned.worst = name;
    if (settings.left_out.size() >= parts / 5) break;
    settings.left_out.push_back(part);
    cleaned.dropped.push_back(name);
    cleaned.solution = solve(problem, settings);
  }
  if (cleaned.solution.log_probability() > std::log(chance)) {
    cleaned.worst.clear();
    return cleaned;
  }
  settings = before;
  return {solution, {}, cleaned.worst};
}

TermTest test_g_sensitivity(const Solution& solution, double significance) {
  const auto uncertainty = solution.estimator.uncertainty(solution.model);
  std::vector<Index> at;
  for (std::size_t i = 0; i < uncertainty.determined.size(); ++i)
    if (coefficient_table()[static_cast<std::size_t>(uncertainty.determined[i])].term == Term::g_sensitivity) at.push_back(static_cast<Index>(i));
  TermTest test{"gyro.g_sensitivity", 0, static_cast<int>(at.size()), 1, false};
  if (at.empty()) return test;
  VectorXd value(static_cast<Index>(at.size()));
  for (std::size_t i = 0; i < at.size(); ++i)
    value[static_cast<Index>(i)] = coefficient_value(solution.model, uncertainty.determined[static_cast<std::size_t>(at[i])]);
  test.statistic = value.dot(Eigen::MatrixXd(uncertainty.covariance(at, at)).ldlt().solve(value));
  test.p_value = chi_square_tail(test.statistic, test.degrees_of_freedom);
  test.kept = test.p_value <= significance;
  return test;
}

void compare_noise(const TableObservations& seen, const SensorModel& model, const ImuDeclaration& imu, Quality& quality) {
  const auto compare = [&](const char* what, const std::optional<double>& declared, const Vector3d& measured, const Matrix3d& matrix) {
    if (!declared || !(measured.norm() > 0)) return;
    const double ratio = measured.norm() / std::sqrt(raw_density(*declared, matrix).trace());
    if (ratio > 1.5 || ratio < 1 / 1.5)
      quality.warnings.push_back(
          fmt::format("the {}' noise at rest is {:.2g} times the declared density; the declared one sets the weights", what, ratio));
  };
  compare("accelerometers", imu.accel_noise_density, seen.accel_density, model.accel.matrix);
  compare("gyros", imu.gyro_noise_density, seen.gyro_density, model.gyro.matrix);
}

/// Residuals against the declared noise and table.
void judge_residuals(const Solution& solution, const std::string& worst, Quality& quality, std::vector<std::string>& doubts) {
  quality.degrees_of_freedom = solution.estimator.degrees_of_freedom();
  quality.condition = solution.estimator.condition();
  quality.chi2_per_dof = solution.chi2 / std::max(1, quality.degrees_of_freedom);
  if (quality.degrees_of_freedom < 1) return;
  if (solution.log_probability() < std::log(chance)) {
    quality.warnings.push_back(
        fmt::format("the residuals are {:.3g} times what the noise and the declared table errors explain: the uncertainties are too small{}",
                    std::sqrt(quality.chi2_per_dof), worst.empty() ? "" : "; most of all " + worst));
    doubts.push_back("the residuals exceed the declared noise and table errors");
  } else if (chi_square_tail(solution.chi2, quality.degrees_of_freedom) > 1 - chance) {
    quality.warnings.push_back(
        fmt::format("the residuals are only {:.3g} times what the noise and the declared table errors explain: the table may be better than declared",
                    std::sqrt(quality.chi2_per_dof)));
  }
}

}  // namespace

Calibration calibrate_turntable(const TableObservations& seen, const RigDeclaration& rig, const ImuDeclaration& imu, const Site& site,
                                const TurntableOptions& options) {
  const TableMotion motion(seen, rig, site);
  const Problem problem{seen, motion, imu, seen.values()};
  TurntableSettings settings;
  settings.terms = options.terms.empty() ? supplied_coefficients() : chosen_coefficients(options.terms);
  settings.bias_while_turning = options.bias_while_turning;
  Solution solution = solve(problem, settings);
  check_units(seen, solution.model);

  const std::string reversal = reversed_axis(problem, solution, rig, site, settings);
  Cleaned cleaned = reversal.empty() ? drop_outliers(problem, solution, settings, options.outlier_level) : Cleaned{solution, {}, {}};
  Calibration calibration;
  Quality& quality = calibration.quality;
  if (options.terms.empty()) {
    quality.term_tests.push_back(test_g_sensitivity(cleaned.solution, options.significance));
    if (!quality.term_tests.back().kept) {
      settings.terms = without_g_sensitivity(settings.terms);
      cleaned.solution = solve(problem, settings);
    }
  }

  const auto uncertainty = cleaned.solution.estimator.uncertainty(cleaned.solution.model);
  if (uncertainty.determined.empty())
    throw Unsupported("the steps determine no coefficient: holds with each axis up and down, and turns about each axis, are needed");
  calibration.imu = imu.name;
  calibration.method = "turntable";
  calibration.frame = "rig";
  calibration.model = cleaned.solution.model;
  calibration.estimated = uncertainty.determined;
  calibration.covariance = uncertainty.covariance;
  for (const int index : uncertainty.undetermined) quality.unobservable.emplace_back(coefficient_table()[static_cast<std::size_t>(index)].name);
  quality.notes = seen.notes;
  quality.warnings = seen.warnings;
  const double relative = site.gravity_sigma() / site.gravity();
  quality.sources.push_back(
      {"gravity", relative, fmt::format("g is known to {:.3g} ppm: this much is common to all three accelerometer scales", 1e6 * relative)});
  if (!site.latitude)
    quality.notes.push_back("no latitude: Earth's rate was taken as unknown up to its size (15 deg/h) and is counted in the gyros' uncertainties");
  compare_noise(seen, calibration.model, imu, quality);
  std::vector<std::string> doubts;
  if (!reversal.empty()) {
    quality.warnings.push_back(reversal);
    doubts.push_back("the sign of an axis seems to be wrong");
  }
  for (const std::string& name : cleaned.dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  judge_residuals(cleaned.solution, cleaned.worst, quality, doubts);
  for (const std::string& doubt : common_doubts(calibration, cleaned.dropped.size(), seen.holds.size() + seen.turns.size())) doubts.push_back(doubt);
  conclude(calibration, doubts);
  return calibration;
}

Calibration calibrate_turntable(const Recording& recording, const Session& session, const TurntableOptions& options) {
  return calibrate_turntable(observe(recording, session), turntable_of(session, recording.name), session.imu, session.site, options);
}

}  // namespace imulab
