#include "imulab/estimate/turntable/fit.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/slow_noise.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/session.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Returns the square root of the sum of squares of the columns about their mean.
double spread(const MatrixXd& columns) { return columns.size() == 0 ? 0 : (columns.colwise() - columns.rowwise().mean().eval()).norm(); }

/// Returns the start: for counts from the size of the readings, for SI readings the identity.
SensorModel starting_model(const TableProblem& problem) {
  const TableMotion& motion = problem.motion;
  const auto holds = static_cast<Index>(motion.holds()), turns = static_cast<Index>(motion.turns());
  const VectorXd truth = motion.truth(motion.nominal());
  const VectorXd& readings = problem.seen.readings;
  const auto motions = truth.reshaped(6, holds + turns);  // forces, then rates
  const auto scale = [](const MatrixXd& inputs, const MatrixXd& outputs) {
    const double input = spread(inputs), output = spread(outputs);
    return input > 0 && output > 0 ? input / output : 1;
  };
  SensorModel start;
  if (problem.seen.accel_unit == "count")
    start.accel.matrix *= scale(motions.topLeftCorner(3, holds), readings.head(6 * holds).reshaped(6, holds).topRows(3));
  if (problem.seen.gyro_unit == "count") start.gyro.matrix *= scale(motions.bottomRightCorner(3, turns), readings.tail(3 * turns).reshaped(3, turns));
  return start;
}

/// Returns the covariance of a part's mean (holds) or integral (turns) on one axis, in the unit of the noise, parts x parts: quantization, and bias
/// instability, walk and ramp about their mean over all parts, which belongs to the offset of the recording. Empty if no such noise is declared.
MatrixXd slow_noise(const TableMotion& motion, const NoiseModel& noise, double interval_s) {
  const auto parts = static_cast<Index>(motion.parts());
  std::vector<kernel::TimeSpan> times;
  VectorXd duration(parts), gain(parts);
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const auto i = static_cast<Index>(k);
    times.push_back({motion.begin(k), motion.end(k)});
    duration[i] = motion.end(k) - motion.begin(k), gain[i] = motion.gain(k);
  }
  const double start = parts == 0 ? 0 : std::min_element(times.begin(), times.end(), [](auto& a, auto& b) { return a.begin < b.begin; })->begin;
  for (kernel::TimeSpan& t : times) t.begin -= start, t.end -= start;
  MatrixXd out = kernel::slow_noise(times, noise, interval_s);
  if (out.size() > 0) {
    const MatrixXd about_mean = MatrixXd::Identity(parts, parts) - VectorXd::Ones(parts) * duration.transpose() / duration.sum();
    out = about_mean * out * about_mean.transpose();
  } else if (noise.Q > 0) {
    out.setZero(parts, parts);
  }
  if (noise.Q > 0) out.diagonal().array() += 2 * noise.Q * noise.Q / duration.array().square();  // error of the integral at both ends
  return out.size() > 0 ? MatrixXd(gain.asDiagonal() * out * gain.asDiagonal()) : out;
}

/// Returns the slow noise of both triads in raw readings.
MatrixXd raw_slow_noise(const TableMotion& motion, const SensorModel& model, const MatrixXd& accel, const MatrixXd& gyro) {
  if (accel.size() == 0 && gyro.size() == 0) return {};
  MatrixXd out = MatrixXd::Zero(motion.rows(), motion.rows());
  const Matrix3d of_accel = raw_density(1, model.accel.matrix), of_gyro = raw_density(1, model.gyro.matrix);
  for (std::size_t a = 0; a < motion.parts(); ++a)
    for (std::size_t b = 0; b < motion.parts(); ++b) {
      const auto row = static_cast<Index>(a), column = static_cast<Index>(b);
      if (gyro.size() > 0) out.block<3, 3>(motion.gyro_row(a), motion.gyro_row(b)) = gyro(row, column) * of_gyro;
      if (accel.size() > 0 && motion.is_hold(a) && motion.is_hold(b)) out.block<3, 3>(motion.row(a), motion.row(b)) = accel(row, column) * of_accel;
    }
  return out;
}

/// Returns the declared noise, or the noise of the samples in the holds. A stuck axis has no noise; 1e-8 of the scale keeps its weights finite.
RawNoise raw_noise(const TableProblem& problem, const SensorModel& model) {
  const auto noise = [](double declared, const Vector3d& measured, const Matrix3d& matrix, double size) -> Matrix3d {
    if (declared > 0) return raw_density(declared, matrix);
    return measured.cwiseMax(1e-8 * size / std::cbrt(std::abs(matrix.determinant()))).cwiseAbs2().asDiagonal();
  };
  const NoiseModels declared = declared_terms(problem.imu);
  return {noise(declared.accel.N, problem.seen.accel_density, model.accel.matrix, unit::g),
          noise(declared.gyro.N, problem.seen.gyro_density, model.gyro.matrix, 1),
          raw_slow_noise(problem.motion, model, problem.accel_slow_noise, problem.gyro_slow_noise)};
}

bool left_handed(const SensorModel& model) { return model.accel.matrix.determinant() < 0 || model.gyro.matrix.determinant() < 0; }

/// Describes how the axes of the gyros' readings differ from those of the accelerometers; empty for counts, which may have either sign.
std::string wrong_axes_of(const TableProblem& problem, const SensorModel& model) {
  if (problem.seen.accel_unit == "count" || problem.seen.gyro_unit == "count") return {};
  const double mirror = model.accel.matrix.determinant() < 0 ? -1 : 1;  // a rate transforms as an axial vector
  return wrong_axes(mirror * model.accel.matrix.inverse() * model.gyro.matrix);
}

/// Returns true if no stated coefficient changed by more than its uncertainty.
bool close(const Estimator& estimator, const SensorModel& before, const SensorModel& after) {
  const Estimator::Uncertainty uncertainty = estimator.uncertainty(after);
  const VectorXd change = coefficient_values(after, uncertainty.stated) - coefficient_values(before, uncertainty.stated);
  return (change.cwiseAbs2().array() <= uncertainty.covariance.diagonal().array()).all();
}

/// Returns the problem with the direction of one axis reversed in the steps.
TableProblem reversed(const TableProblem& problem, std::size_t axis) {
  TableObservations seen = problem.seen;
  for (Step& step : seen.parts.steps) {
    step.angles[axis] = -step.angles[axis];
    if (step.kind == StepKind::rotate && static_cast<std::size_t>(step.axis) == axis) step.angle = -step.angle;
  }
  return {std::move(seen), problem.rig, problem.imu, problem.site};
}

}  // namespace

TableProblem::TableProblem(TableObservations observations, RigDeclaration table, ImuDeclaration unit, Site place)
    : seen(std::move(observations)), rig(std::move(table)), imu(std::move(unit)), site(place), motion(seen.parts, rig, site) {
  const NoiseModels noise = declared_terms(imu);
  accel_slow_noise = slow_noise(motion, noise.accel, seen.interval_s);
  gyro_slow_noise = slow_noise(motion, noise.gyro, seen.interval_s);
}

double Fit::log_probability() const { return log_chi_square_tail(chi2, std::max(1, estimator.degrees_of_freedom())); }

std::vector<kernel::Suspect> Fit::suspects() const {
  std::vector<kernel::Suspect> out;
  for (const double log_p : estimator.log_probabilities(readings)) {
    const std::size_t step = problem->motion.step(out.size());
    out.push_back({step_name(problem->seen.parts.steps[step], step), log_p});
  }
  return out;
}

bool Fit::may_drop(std::size_t part) const {
  const TableMotion& motion = problem->motion;
  const auto turns = std::count_if(options.left_out.begin(), options.left_out.end(), [&](std::size_t p) { return !motion.is_hold(p); });
  return options.left_out.size() < motion.parts() / 5 && (motion.is_hold(part) || 3 * (static_cast<std::size_t>(turns) + 1) <= motion.turns());
}

Fit Fit::without(std::size_t part) const {
  EstimatorOptions fewer = options;
  fewer.left_out.push_back(part);
  return fit(*problem, fewer);
}

Fit fit(const TableProblem& problem, const EstimatorOptions& options) {
  SensorModel model = starting_model(problem);
  EstimatorOptions now = options;
  now.table_errors = false;
  model = Estimator(problem.motion, model, raw_noise(problem, model), now).estimate(problem.seen.readings);
  now.table_errors = true;
  const auto usable = [](const TriadModel& triad) { return triad.matrix.allFinite() && triad.matrix.determinant() != 0; };
  for (int pass = 0;; ++pass) {
    count_iteration();
    if (!usable(model.accel) || !usable(model.gyro))
      throw Unsupported("the readings do not follow the table's motion: a triad's readings do not span three axes");
    Estimator estimator(problem.motion, model, raw_noise(problem, model), now);
    const VectorXd readings = estimator.linearized(problem.seen.readings);
    const SensorModel before = std::exchange(model, estimator.estimate(readings));
    const double chi2 = estimator.chi2(readings);
    const VectorXd errors = estimator.table_errors(readings);
    constexpr int enough = 1, most = 6;  // numbers of passes about the start; the second for noise far below the table's errors
    constexpr double largest = 1;        // rad, s, m/s^2: a table and its site have no larger errors, and the equations would not be linear
    const bool converged = pass >= enough && close(estimator, before, model);
    const bool diverges = !((errors - problem.motion.nominal()).cwiseAbs().maxCoeff() < largest);
    if (converged || diverges || pass == most) return {&problem, options, std::move(estimator), readings, model, chi2, converged};
    now.around = errors;
  }
}

Fit enlarged(const Fit& declared, double most) {
  if (declared.estimator.degrees_of_freedom() < 1) return declared;
  constexpr int most_passes = 50;        // limit for a fixed-point iteration, which converges linearly
  constexpr double close_enough = 0.02;  // relative change of a variance: one percent of the stated uncertainties
  Fit now = declared;
  for (int pass = 0; pass < most_passes; ++pass) {
    const Vector3d ratio = now.estimator.variance_ratios(now.readings);
    EstimatorOptions options = now.options;
    double change = 0;
    for (const auto& [factor, by] :
         {std::pair{&options.enlarged.accel, ratio[0]}, {&options.enlarged.gyro, ratio[1]}, {&options.enlarged.table, ratio[2]}}) {
      if (!(by > 0) || !std::isfinite(by)) continue;
      const double next = std::clamp(*factor * std::sqrt(by), 1.0, most);
      change = std::max(change, std::abs(next * next / (*factor * *factor) - 1));
      *factor = next;
    }
    if (change < close_enough) break;
    now = fit(*now.problem, options);
  }
  return now;
}

std::string reversed_axis(const Fit& declared) {
  const bool mirrored = left_handed(declared.model);
  if (!mirrored && declared.log_probability() > std::log(unlikely)) return {};
  constexpr double obvious = 30;  // difference of chi-square: five sigma
  std::string found;
  double best = declared.chi2 + (mirrored ? obvious : -obvious);  // the prior evidence of handedness
  for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner}) {
    const TableProblem problem = reversed(*declared.problem, static_cast<std::size_t>(axis));
    EstimatorOptions options = declared.options;
    options.effects = on_motion(std::move(options.effects), problem.motion, problem.seen.parts, problem.site);
    const Fit other = fit(problem, options);
    if (left_handed(other.model) || other.chi2 >= best) continue;
    // A mirror image exchanges the axes of both triads, but a reversed sensor remains reversed.
    if (mirrored && !wrong_axes_of(problem, other.model).empty()) continue;
    best = other.chi2;
    const bool by_chi2 = other.chi2 + obvious < declared.chi2;
    const std::string falls = by_chi2 ? fmt::format("chi-square falls from {:.4g} to {:.4g}", declared.chi2, other.chi2) : "";
    found = fmt::format("the {} axis seems to turn against the sign of its angles: with it reversed {}{}{}", to_string(axis), falls,
                        mirrored && !falls.empty() ? ", and " : "", mirrored ? "the sensors' axes become right-handed" : "");
  }
  if (found.empty() && mirrored) found = wrong_axes_of(*declared.problem, declared.model);
  if (found.empty() && mirrored) found = "a triad is left-handed in the table's axes: a sensor's or a table axis's sign is reversed";
  return found;
}

kernel::Cleaned<Fit> without_outliers(const Fit& fit, double level) {
  kernel::Cleaned<Fit> cleaned = kernel::drop_suspects(fit, level);
  if (cleaned.fit.log_probability() <= std::log(unlikely)) return {fit, {}, cleaned.worst, cleaned.clean};
  cleaned.worst.clear();
  return cleaned;
}

std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, std::string_view accel_unit,
                                                  std::string_view gyro_unit) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(
      wanted, select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}), "turntable");
  enum class Share { none, some, all };
  const auto share = [&](const std::string& selector) {
    const std::vector<CoefficientIndex> whole = select_coefficients(selector);
    const auto n = std::count_if(whole.begin(), whole.end(), [&](CoefficientIndex index) { return contains(chosen, index); });
    return n == std::ssize(whole) ? Share::all : n > 0 ? Share::some : Share::none;
  };
  for (const auto& [triad, unit] : {std::pair{std::string("accel"), accel_unit}, {std::string("gyro"), gyro_unit}}) {
    const Share diagonal = share(triad + ".matrix.diagonal"), others = share(triad + ".matrix.off_diagonal");
    if (diagonal == Share::some || others == Share::some || (others == Share::all && diagonal == Share::none))
      throw TermsError(fmt::format("{0}.matrix in parts: the method turntable estimates all of it, or {0}.matrix.diagonal, or none", triad));
    if (unit == "count" && (share(triad + ".offset") == Share::none || diagonal == Share::none))
      throw TermsError(
          fmt::format("without {0}.offset or {0}.matrix.diagonal: readings in counts have no bias and scale factor to start from", triad));
  }
  for (const char* term : {"accel.offset", "gyro.offset", "gyro.g_sensitivity"})
    if (share(term) == Share::some) throw TermsError(fmt::format("{} in parts: the method turntable estimates all of it or none", term));
  return chosen;
}

EstimatorOptions with_optional_terms(EstimatorOptions options, const ImuDeclaration& imu) {
  for (const CoefficientIndex index : select_each({"accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic"})) options.terms.push_back(index);
  std::sort(options.terms.begin(), options.terms.end());
  options.optional = kernel::optional_priors(imu);
  return options;
}

}  // namespace imulab::turntable
