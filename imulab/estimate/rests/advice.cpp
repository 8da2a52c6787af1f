#include "imulab/estimate/rests/advice.hpp"

#include "imulab/core/units.hpp"
#include "imulab/recording/turn.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;

/// A turn and how willingly a hand does it: a part of its gain counts.
struct Candidate {
  HandTurn turn;
  double handy;
};

/// From a pose with `up` up: to each face, edge and corner by the short and the long way; over to the other side about each axis.
std::vector<Candidate> candidates(const Vector3d& up) {
  constexpr double shortest = 40 * unit::deg, longest = 290 * unit::deg;  // an eighth to three quarters of a turn, from a pose that is not quite
  constexpr double opposite = 160 * unit::deg;                            // as it was asked for
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
    if (const Vector3d level = to - up * up.dot(to); elements < 3 && level.norm() > -std::cos(opposite))  // both ways round: `to` and its opposite
      out.push_back({{level.normalized(), -up, pi}, 1});
    // About an edge by half a turn, or a corner by a third: one face takes the place of another, and two or three gyros turn.
    if (elements > 1)
      for (const double by : {pi, 2 * pi / 3})
        if (const Vector3d then = rotation_exp(Vector3d(-by * to)) * up; (by == pi) == (elements == 2) && then.dot(up) < std::cos(shortest))
          out.push_back({{to, then, by}, 0.9});
  }
  return out;
}

/// How far a covariance is from the goal.
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

  /// Of each coefficient, at most one where the goal is reached.
  VectorXd of(HandheldProblem& problem, const Fit& fit) const {
    const Index n = needed_.size();
    const Conditions conditions = problem.conditions(fit.spreads);
    const Eigen::MatrixXd covariance =
        fit.excess * fit.excess * kernel::solve(conditions.information(), problem.parameters(), "the rests").covariance.topLeftCorner(n, n);
    const VectorXd raw = raw_covariance(problem, covariance).diagonal().cwiseSqrt();
    return covariance.diagonal().cwiseSqrt().cwiseQuotient(needed_).cwiseMax(raw.cwiseQuotient(limit_));
  }
  /// Sum of the logarithms of the ratios above nearly one, and a little of the worst.
  double distance(HandheldProblem& problem, const Fit& fit) const {
    constexpr double nearly = 0.8, little = 0.01;
    const VectorXd ratio = of(problem, fit);
    return (ratio / nearly).cwiseMax(1).array().log().sum() + little * std::log(ratio.maxCoeff());
  }

 private:
  VectorXd needed_, limit_;  ///< to be determined, of scaled readings; to meet the requirements, of raw ones
};

}  // namespace

void HandheldProblem::extend(const Vector3d& axis, double angle, double rest_s) {
  constexpr int pieces = 40;                      // of the turn: of a few degrees each
  constexpr double rate = 1.5, acceleration = 3;  // rad/s, rad/s^2: of a hand
  const Vector3d force = gravity_ * last_up();
  const Matrix3d to_accel = model_.accel.matrix.inverse(), to_gyro = model_.gyro.matrix.inverse();
  const double duration = turn_duration(angle, rate, acceleration), dt = duration / pieces;
  const auto turned = [&](double t) { return turn_state(angle, rate, acceleration, t).angle; };
  const auto accel_of = [&](double by) { return Vector3d(to_accel * (rotation_exp(Vector3d(-by * axis)) * force - model_.accel.offset)); };
  const auto reading_at = [&](const Vector3d& scaled, bool accel) {
    return Vector3d(accel ? scaling_.accel_center + scaling_.accel_scale.cwiseProduct(scaled)
                          : scaling_.gyro_center + scaling_.gyro_scale.cwiseProduct(scaled));
  };
  const auto gyro_of = [&](const Vector3d& rate_b, const Vector3d& accel) {
    return Vector3d(to_gyro * (rate_b - model_.gyro.offset - model_.g_sensitivity * output(model_.accel, accel)));
  };
  Recording turn;
  turn.interval_s = dt, turn.gyro_increment = true;  // every sample lasts dt
  turn.time_ns.resize(pieces);
  for (int i = 0; i < pieces; ++i) {
    const double begin = turned(i * dt), end = turned((i + 1) * dt);
    const Vector3d accel = accel_of(0.5 * (begin + end)), a = reading_at(accel, true),
                   g = reading_at(gyro_of((end - begin) / dt * axis, accel), false);
    for (std::size_t j = 0; j < 3; ++j) turn.accel[j].push_back(a[static_cast<Index>(j)]), turn.gyro[j].push_back(g[static_cast<Index>(j)]);
  }
  Link link;
  link.usable = true;
  link.rotation = link.now = integrate_rotation(turn, {0, pieces}, model_, scaling_, std::sqrt(recording_->interval_s / dt) * turning_sigma_);
  link.at = model_;
  const Vector3d accel = accel_of(angle);
  RestMeans rest;
  rest.range = {0, std::max<std::size_t>(1, static_cast<std::size_t>(rest_s / recording_->interval_s))};
  rest.accel = reading_at(accel, true), rest.gyro = reading_at(gyro_of(Vector3d::Zero(), accel), false);
  rests_.push_back(rest);
  links_.push_back(link);
  stretch_.push_back(stretch_.back());
}

std::vector<HandTurn> next_turns(HandheldProblem problem, const Fit& fit, const CalibrationOptions::Handheld& goal) {
  const Ratios ratios(problem, goal.requirements);
  std::vector<HandTurn> out;
  if (ratios.of(problem, fit).maxCoeff() <= 1) return out;
  problem.release();  // terms that blur the others because the rests so far do not tell them from these
  while (out.size() < goal.advised_turns && (out.empty() || ratios.of(problem, fit).maxCoeff() > 1)) {
    const double distance = ratios.distance(problem, fit);
    double best_gain = 0;
    std::optional<HandTurn> best;
    for (const Candidate& candidate : candidates(problem.last_up())) {
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

HandTurn opening_turn(std::size_t rests) {
  // Each time the axis that comes up was level, and the one about which the unit turns stays level.
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const HandTurn turns[] = {{-y, x, pi / 2}, {-z, y, pi / 2}, {-x, z, pi / 2}, {y, -x, pi / 2}, {-z, -y, pi / 2}, {-x, -z, pi / 2}};
  return turns[(rests + 5) % 6];
}

}  // namespace imulab::rests
