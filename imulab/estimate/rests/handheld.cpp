#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/coarse/rest_start.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace imulab::rests {

using coarse::RestStart;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;

/// A turn with a weight for its ease by hand, which multiplies its gain.
struct Candidate {
  HandTurn turn;
  double handy;
};

/// Returns turns from a pose with `up` up: to each face, edge and corner in both directions; and to the opposite side about each axis.
std::vector<Candidate> candidates(const Vector3d& up) {
  constexpr double shortest = 40 * unit::deg, longest = 290 * unit::deg;  // an eighth to three quarters of a turn,
  constexpr double opposite = 160 * unit::deg;                            // from an inexact pose
  constexpr double rests[] = {1, 0.9, 0.8}, long_way = 0.9;               // a face needs no support
  std::vector<Candidate> out;
  for (int code = 0; code < 27; ++code) {
    const Vector3d corner = Eigen::Vector3i(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1).cast<double>();
    if (corner.isZero()) continue;
    const Vector3d to = corner.normalized();
    const auto elements = static_cast<std::size_t>(std::lround(corner.squaredNorm()));
    const double angle = std::acos(std::clamp(up.dot(to), -1.0, 1.0));
    if (angle > shortest && angle < opposite) {
      const Vector3d axis = to.cross(up).normalized();
      out.push_back({{axis, to, angle}, rests[elements - 1]});
      if (2 * pi - angle < longest) out.push_back({{-axis, to, 2 * pi - angle}, long_way * rests[elements - 1]});
    }
    if (const Vector3d level = to - up * up.dot(to); elements < 3 && level.norm() > -std::cos(opposite))  // both directions: `to` and its opposite
      out.push_back({{level.normalized(), -up, pi}, 1});
    // Half a turn about an edge, or a third about a corner: one face replaces another, and two or three gyros turn.
    if (elements > 1)
      for (const double by : {pi, 2 * pi / 3})
        if (const Vector3d then = rotation_exp(Vector3d(-by * to)) * up; (by == pi) == (elements == 2) && then.dot(up) < std::cos(shortest))
          out.push_back({{to, then, by}, 0.9});
  }
  return out;
}

/// Compares a covariance with the goal.
class Ratios {
 public:
  Ratios(const HandheldProblem& problem, const std::vector<Requirement>& requirements)
      : needed_(std::ssize(problem.indices())), limit_(needed_.size()) {
    const SensorModel raw = to_raw(problem.model(), problem.scaling());
    for (Index i = 0; i < needed_.size(); ++i) {
      const CoefficientIndex index = problem.indices()[static_cast<std::size_t>(i)];
      const Coefficient& c = coefficient(index);
      constexpr double unlimited = std::numeric_limits<double>::infinity();
      needed_[i] = is_optional(c.term) ? unlimited : kernel::needed_sigma(c, problem.prior_sigma(c));
      limit_[i] = unlimited;
      const double scale = c.term == Term::matrix ? std::abs(triad_model(raw, c.triad).matrix(c.row, c.row)) : 1;
      for (const Requirement& r : requirements)
        if (contains(r.coefficients, index)) limit_[i] = std::min(limit_[i], r.limit * scale);
    }
  }

  /// Returns the ratios of all coefficients; each is at most one if the goal is reached.
  VectorXd of(HandheldProblem& problem, const Fit& fit) const {
    const Index n = needed_.size();
    const Conditions conditions = problem.conditions(fit.spreads);
    const kernel::Solution solution = kernel::solve(conditions.information(), problem.parameters(), "the rests");
    const Eigen::MatrixXd covariance = fit.excess * fit.excess * solution.covariance.topLeftCorner(n, n);
    const VectorXd raw = raw_covariance(problem, covariance).diagonal().cwiseSqrt();
    const double degrees = std::max(solution.degrees_of_freedom, 1.0), factor = StatedSigma{1, degrees}.compared();
    const VectorXd ratio = covariance.diagonal().cwiseSqrt().cwiseQuotient(needed_).cwiseMax((factor * raw).cwiseQuotient(limit_));
    const bool unmet = std::isfinite(limit_.minCoeff()) && !StatedSigma{1, degrees}.has_enough();
    return unmet ? VectorXd(ratio.cwiseMax(4 - degrees)) : ratio;  // above 1 until the residuals can check the uncertainties
  }
  /// Returns the sum of the logarithms of ratios above nearly one, plus a small part of the largest.
  double distance(HandheldProblem& problem, const Fit& fit) const {
    constexpr double nearly = 0.8, little = 0.01;
    const VectorXd ratio = of(problem, fit);
    return (ratio / nearly).cwiseMax(1).array().log().sum() + little * std::log(ratio.maxCoeff());
  }

 private:
  VectorXd needed_, limit_;  ///< to be determined, scaled readings; to meet the requirements, raw readings
};

/// Returns the most useful next turns of a calibration by hand. Each minimizes the sum of the logarithms of uncertainty over requirement (for
/// coefficients that do not reach it) among turns about horizontal axes, in both directions, that point a face, edge or corner of the unit up. The
/// fit supplies the information of the past with its spreads; future rests use the same conditions. Ends when the goal is reached: without
/// requirements, when every coefficient that all IMUs have is determined.
std::vector<HandTurn> next_turns(HandheldProblem problem, const Fit& fit, const CalibrationOptions::Handheld& goal) {
  const Ratios ratios(problem, goal.requirements);
  std::vector<HandTurn> out;
  if (ratios.of(problem, fit).maxCoeff() <= 1) return out;
  problem.release();  // releases terms that widen others because the rests so far do not separate them
  while (out.size() < goal.advised_turns && (out.empty() || ratios.of(problem, fit).maxCoeff() > 1)) {
    const double distance = ratios.distance(problem, fit);
    double best_gain = 0;
    std::optional<HandTurn> best;
    for (const Candidate& candidate : candidates(problem.last_up())) {
      stop_point();
      HandheldProblem then = problem;
      then.extend(candidate.turn.axis, candidate.turn.angle, goal.rest_s);
      const double gain = candidate.handy * (distance - ratios.distance(then, fit));
      if (!best || gain > best_gain) best = candidate.turn, best_gain = gain;
    }
    problem.extend(best->axis, best->angle, goal.rest_s);
    out.push_back(*best);
  }
  return out;
}

bool near_diagonal(const Matrix3d& matrix) {
  return (matrix.rowwise().norm() - matrix.diagonal().cwiseAbs()).cwiseQuotient(matrix.rowwise().norm()).maxCoeff() < 0.1;
}

/// Axes may be swapped or rotated, but gyros in SI must have the declared scale and orthogonal axes. Motion about too few axes gives any matrix.
bool possible(const Matrix3d& matrix) {
  const Vector3d lengths = singular_values(matrix).values;
  return lengths.minCoeff() > 0.8 && lengths.maxCoeff() < 1.2;  // 20 % as elsewhere: scale errors are a few percent
}

/// Sets the gyros' starting offset and matrix from the motion if that determines them, else from the declared unit. Turns with declared angles verify
/// the unit better than fast motion by hand.
void start_gyro(RestStart& start, const Recording& recording, bool declared_turns) {
  const bool counts = recording.gyro_unit == "count";
  std::optional<Matrix3d> coarse = coarse::coarse_gyro_in_common_turns(recording, start);
  if (!counts && declared_turns) coarse.reset();
  TriadModel& gyro = start.model.gyro;
  if (coarse) gyro.matrix = *coarse;
  if (!coarse && counts)
    throw Unsupported(fmt::format(
        "{}: the motion between the rests does not turn the IMU about all three axes: the gyros' scales cannot be determined", recording.name));
  if (!counts && coarse) kernel::expect_gyro_scale(*coarse, recording);
  if (!counts && !possible(gyro.matrix)) gyro.matrix.setIdentity();
  gyro.offset = -gyro.matrix * start.scaling.gyro(mean_gyro(start.rests));
  // For axes that are not as declared (swapped, rotated) and for counts, the best prior is the coarse solution itself.
  if (counts) {
    start.prior.gyro.offset = gyro.offset;
    start.prior.gyro.matrix = near_diagonal(gyro.matrix) ? Matrix3d(gyro.matrix.diagonal().asDiagonal()) : gyro.matrix;
  } else if (!coarse::near_identity(gyro.matrix)) {
    start.prior.gyro.matrix = gyro.matrix;
  }
}

/// Cross-validation: gravity propagated by the gyros across a rotation, compared with gravity measured after it, for each tenth of the rotations left
/// out. Rotations below 10 deg are skipped because any gyro predicts them well.
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
    if (std::any_of(steps.begin(), steps.end(), rotates)) findings.add<Code::turns_without_sigma>();
    return;
  }
  findings.add<Code::turns_used>(problem.turns(), turns.size(), turns.front().angle_sigma() / unit::deg);
  if (usable < turns.size()) findings.add<Code::turns_not_used>(turns.size() - usable, turns.size());
  if (problem.turns(true) > 0) findings.add<Code::wrong_turn>();
}

/// The other hemisphere is another minimum that steps do not reach. The wrong latitude is more probable by x in at most 1 of 140 sessions, for any
/// gyro resolution: P(Z > sqrt(2 x)).
void doubt_hemisphere(kernel::Findings& findings, const HandheldProblem& problem, const Fit& fit) {
  constexpr double more_likely = 3;  // logarithm
  if (problem.effects().size() == 0 || findings.has(Code::wrong_latitude)) return;
  HandheldProblem mirrored = problem;
  mirrored.mirror_latitude();
  const Fit there = converge(mirrored, fit.spreads);
  const auto log_probability = [](const Fit& f) { return kernel::log_probability(f.conditions.information(), f.parameters, "the rests"); };
  if (!there.converged || !(log_probability(there) - log_probability(fit) > more_likely)) return;
  findings.add<Code::latitude_of_other_sign>("");
  findings.add<Code::wrong_latitude>();
}

}  // namespace

HandTurn opening_turn(std::size_t rests) {
  // Each axis that is turned up was level before, and the turn is about an axis that remains level.
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const HandTurn turns[] = {{-y, x, pi / 2}, {-z, y, pi / 2}, {-x, z, pi / 2}, {y, -x, pi / 2}, {-z, -y, pi / 2}, {-x, -z, pi / 2}};
  return turns[(rests + 5) % 6];
}

bool sweeps_in_one_attitude(const RestStart& start, const Recording& recording) {
  constexpr std::size_t several = 5;
  constexpr double one_direction = 10 * unit::deg;
  if (start.rests.size() < several || recording.gyro_unit == "count") return false;
  for (std::size_t k = 0; k < start.rests.size(); ++k)
    if (!is_part_of_rest(recording, start.rests, k) || start.up(start.rests[k]).dot(start.up(start.rests[0])) < std::cos(one_direction)) return false;
  const auto is_dead = [](const std::vector<double>& column) { return std::ranges::min(column) == std::ranges::max(column); };
  if (std::ranges::any_of(recording.gyro, is_dead))
    throw Unsupported(recording.name +
                      ": one attitude shows how the accelerometers' biases follow the temperature if gyros show that it stays, and they do not "
                      "vary; expected gyros, or rests in nine directions");
  return true;
}

CalibrationResult calibrate_handheld(const CalibrationInput& input, const CalibrationOptions& options) {
  return calibrate_with_links(input, options, "handheld", coarse::start_from_rests(input, "handheld"));
}

CalibrationResult calibrate_with_links(const CalibrationInput& input, const CalibrationOptions& options, std::string_view method, RestStart start) {
  const Recording& recording = input.recordings.front();
  const Session& session = input.session;
  kernel::expect_alive(recording, Triad::gyro, "the method static calibrates the accelerometers alone");
  const std::vector<DeclaredTurn> turns = declared_turns(session, session.source_of(recording.name));
  start_gyro(start, recording, !turns.empty());
  coarse::use_declared_gyro_noise(start, recording, session.imu);
  std::vector<CoefficientIndex> terms = options.terms;
  Vector3d along_gravity = Vector3d::Zero();  // what bias and scale miss of g: one attitude does not tell them apart, and the result has neither
  if (terms.empty() && sweeps_in_one_attitude(start, recording)) {
    terms = select_coefficients("gyro.offset");
    Vector3d force = Vector3d::Zero();  // at the mean temperature
    double samples = 0;
    for (const RestMeans& rest : start.rests) {
      const auto n = static_cast<double>(rest.range.size());
      force += n * output(start.model.accel, start.accel(rest)), samples += n;
    }
    force /= samples;
    along_gravity = (session.site.gravity() / force.norm() - 1) * force;
    start.model.accel.offset += along_gravity, start.prior.accel.offset += along_gravity;
    std::erase_if(start.findings, [](const Finding& f) { return f.code == Code::rests_near_a_plane || f.code == Code::start_of_fit; });
    start.findings.add<Code::one_attitude>();
  }
  const std::vector<CoefficientIndex> indices =
      choose_coefficients(start, session, recording, options.effects, terms, handheld_coefficients(), method);

  HandheldProblem whole(recording, start, session.site, indices, turns);
  const std::size_t usable_turns = whole.turns(), parts = start.rests.size() + whole.rotations();
  auto cleaned = kernel::drop_suspects(SuspectFit(std::move(whole)), options.outlier_level);
  cleaned.fit.next.reset();  // releases memory as large as the next fit's
  HandheldProblem& problem = cleaned.fit.problem;
  const Fit fit = fit_determined(problem, std::move(cleaned.fit.fit));

  CalibrationResult result{.calibration = calibration_of(method, problem, fit, session)};
  result.calibration.model.accel.offset -= along_gravity;
  Quality& quality = result.calibration.quality;
  add_parts(quality, problem.suspects(fit.conditions), fit, cleaned.fit.dropped);
  quality.term_tests = test_terms(problem, fit, options.significance);
  kernel::Findings& findings = start.findings;
  findings.add<Code::parts_used>(fmt::format("{} rests and {} rotations between them", problem.rests().size(), problem.rotations())).numbers = {
      static_cast<double>(problem.rests().size()), static_cast<double>(problem.rotations())};
  add_turns(findings, session.steps, turns, usable_turns, problem);
  if (const CrossValidation check = cross_validate(problem, fit); check.rotations >= 10) {  // a tenth of fewer is less than one rotation
    quality.rotation_residual_deg = check.rms_deg;
    findings.add<Code::held_out_rotations>(check.rms_deg, check.rotations);
  }
  if (!session.site.latitude) findings.add<Code::no_latitude>("is unknown but for its size (15 deg/h); the gyros' uncertainties contain it");
  add_findings(findings, result.calibration, problem, fit, curvature(problem, fit), session.site, cleaned.dropped, parts);
  if (session.site.latitude) doubt_hemisphere(findings, problem, fit);
  // An uncalibrated gyro with 2 % error predicts right-angle turns to about 1 deg.
  if (quality.rotation_residual_deg.value_or(0) > 1) findings.add<Code::poor_rotations>(*quality.rotation_residual_deg);
  kernel::add_effects(result.calibration, findings, problem.effects(), fit.covariance(), 1e-3, problem.indices());
  kernel::conclude(result.calibration, findings);
  result.missing_turns = next_turns(problem, fit, options.handheld);
  return result;
}

}  // namespace imulab::rests
