#include "imulab/estimate/rests/advice.hpp"

#include "imulab/core/units.hpp"

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
  constexpr double near = 20 * unit::deg, rests[] = {1, 0.95, 0.9};  // a face needs no support
  constexpr double long_way = 0.9;
  std::vector<Candidate> out;
  for (int code = 0; code < 27; ++code) {
    const Vector3d corner(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
    if (corner.isZero()) continue;
    const Vector3d to = corner.normalized();
    const auto elements = static_cast<std::size_t>(std::lround(corner.squaredNorm()));
    const double angle = std::acos(std::clamp(up.dot(to), -1.0, 1.0));
    if (angle > near && angle < pi - near) {
      const Vector3d axis = to.cross(up).normalized();
      out.push_back({{axis, to, angle}, rests[elements - 1]});
      out.push_back({{-axis, to, 2 * pi - angle}, long_way * rests[elements - 1]});
    }
    if (const Vector3d level = to - up * up.dot(to); elements < 3 && level.norm() > std::cos(near))  // both ways round: `to` and its opposite
      out.push_back({{level.normalized(), -up, pi}, 1});
  }
  return out;
}

/// How far a covariance is from the goal.
class Ratios {
 public:
  Ratios(const HandheldProblem& problem, const kernel::RestStart& start, const Site& site, const Goal& goal)
      : start_(&start), site_(&site), needed_(std::ssize(problem.indices())), limit_(needed_.size()) {
    const SensorModel raw = to_raw(problem.model(), start.scaling);
    for (Index i = 0; i < needed_.size(); ++i) {
      const CoefficientIndex index = problem.indices()[static_cast<std::size_t>(i)];
      const Coefficient& c = coefficient(index);
      constexpr double unlimited = std::numeric_limits<double>::infinity();
      needed_[i] = is_optional(c.term) ? unlimited : kernel::needed_sigma(c, problem.prior_sigma(c));
      limit_[i] = unlimited;
      const double scale = c.term == Term::matrix ? std::abs((c.triad == Triad::accel ? raw.accel : raw.gyro).matrix(c.row, c.row)) : 1;
      for (const Requirement& r : goal.requirements)
        if (contains(r.coefficients, index)) limit_[i] = std::min(limit_[i], r.limit * scale);
    }
  }

  /// Sum of the logarithms of the ratios above one: 0 where the goal is reached.
  double distance(HandheldProblem& problem, const Fit& fit) const {
    const Index n = needed_.size();
    const Conditions conditions = problem.conditions(fit.spreads);
    const Eigen::MatrixXd covariance =
        fit.excess * fit.excess * kernel::solve(conditions.information(), problem.parameters(), "the rests").covariance.topLeftCorner(n, n);
    const VectorXd raw = raw_covariance(*start_, problem, covariance, *site_).diagonal().cwiseSqrt();
    const VectorXd ratio = covariance.diagonal().cwiseSqrt().cwiseQuotient(needed_).cwiseMax(raw.cwiseQuotient(limit_));
    return ratio.cwiseMax(1).array().log().sum();
  }

 private:
  const kernel::RestStart* start_;
  const Site* site_;
  VectorXd needed_, limit_;  ///< to be determined, of scaled readings; to meet the requirements, of raw ones
};

}  // namespace

std::vector<HandTurn> next_turns(HandheldProblem problem, const Fit& fit, const kernel::RestStart& start, const Site& site, const Goal& goal) {
  const Ratios ratios(problem, start, site, goal);
  std::vector<HandTurn> out;
  for (double distance = ratios.distance(problem, fit); distance > 0 && out.size() < goal.most;) {
    double best_gain = 0, best_distance = distance;
    std::optional<HandTurn> best;
    for (const Candidate& candidate : candidates(problem.last_up())) {
      HandheldProblem then = problem;
      then.extend(candidate.turn.axis, candidate.turn.angle, goal.rest_s);
      const double after = ratios.distance(then, fit), gain = candidate.handy * (distance - after);
      if (best && gain <= best_gain) continue;
      best = candidate.turn, best_gain = gain, best_distance = after;
    }
    if (!best) break;
    problem.extend(best->axis, best->angle, goal.rest_s);
    out.push_back(*best);
    distance = best_distance;
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
