#include "imulab/estimate/hybrid/path_judge.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/recording/turn.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::hybrid {

using Eigen::Index;

namespace {

constexpr int usual_quantum = 5;  // s
constexpr double quarter = std::numbers::pi / 2, acceleration = default_acceleration_dps2 * unit::deg;
constexpr std::array<int, 4> turns{1, 2, -1, -2};

}  // namespace

PathJudge::PathJudge(const PathQuestion& q)
    : quantum(q.rest ? static_cast<int>(std::lround(*q.rest)) : usual_quantum), model_(q.unit), turn_rate_(q.turn_rate) {
  find_limits(q);
  const std::vector<Matrix3d>& attitudes = table_.attitudes();
  const int most = q.rest ? 1 : longest_rest / usual_quantum;  // quanta
  turn_.resize(attitudes.size());
  rest_.resize(attitudes.size());
  parallel_for(attitudes.size(), [&](std::size_t k) {
    for (Index a = 0; a < 3; ++a)
      for (std::size_t t = 0; t < turns.size(); ++t)
        turn_[k][static_cast<std::size_t>(a)][t] =
            turn_information(model_, attitudes[k], {Vector3d::Unit(a), turns[t] * quarter, turn_rate_, acceleration});
    const int of_turns = model_.observe_motion ? 0 : unseen_before + unseen_after,
              at_end = std::max(of_turns, static_cast<int>(in_place::settling_time));
    const MotionInformation one = rest_information(model_, attitudes[k], quantum);
    for (const std::size_t outermost : {0u, 1u}) {
      std::vector<MotionInformation>& rests = rest_[k][outermost];
      rests.push_back(rest_information(model_, attitudes[k], quantum - (outermost == 1 ? at_end : of_turns)));
      for (int quanta = 2; quanta <= most; ++quanta) rests.push_back(joined(rests.back(), one));
    }
  });
}

void PathJudge::find_limits(const PathQuestion& q) {
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex coefficient : r.coefficients)
      for (Index row = 0; row < model_.size(); ++row) {  // none for those of an accelerometer's upper triangle: zero in its frame
        const Index state = model_.constants[static_cast<std::size_t>(row)];
        if (model_.states.corrects(state) != coefficient) continue;
        // Half of the prior is where a coefficient begins to count as determined.
        limits_.push_back({row, coefficient, std::min(r.limit, 0.499 * model_.states.prior[state]), least_sigma(q.unit, coefficient, q.turn_rate),
                           nonlinear_sigma(q.unit, coefficient, q.turn_rate)});
      }
}

const MotionInformation& PathJudge::turn(const QuarterPose& pose, const QuarterTurn& turn) const {
  const auto [along, opposite] = table_.axis(pose, turn.axis);
  const auto angle = std::find(turns.begin(), turns.end(), opposite ? -turn.quarters : turn.quarters) - turns.begin();
  return turn_[table_.attitude(pose)][along][static_cast<std::size_t>(angle)];
}

const MotionInformation& PathJudge::rest(const QuarterPose& pose, int quanta, bool outermost) const {
  return rest_[table_.attitude(pose)][outermost ? 1 : 0][static_cast<std::size_t>(quanta - 1)];
}

double PathJudge::duration(const QuarterTurn& turn) const { return turn_duration(turn.quarters * quarter, turn_rate_, acceleration); }

double PathJudge::duration(const QuarterPath& path) const {
  double sum = 0;
  for (const int rest : path.rests) sum += rest * quantum;
  for (const QuarterTurn& turn : path.turns) sum += duration(turn);
  return sum;
}

Knowledge PathJudge::knowledge(const QuarterPath& path) const {
  QuarterPose pose{};
  Knowledge now = after(start(), rest(pose, path.rests.front(), true));
  for (std::size_t k = 0; k < path.turns.size(); ++k) {
    now = after(now, turn(pose, path.turns[k]));
    pose = turned(pose, path.turns[k]);
    now = after(now, rest(pose, path.rests[k + 1], k + 1 == path.turns.size()));
  }
  return now;
}

Score PathJudge::score(const Knowledge& knowledge) const {
  const Eigen::VectorXd sigma = sigma_of(knowledge);
  Score s;
  for (const Limit& limit : limits_) {
    if (limit.limit <= limit.floor) continue;  // out of reach of any path
    const double excess = std::pow(limit.sigma(sigma[limit.row]), 2) - limit.floor * limit.floor;
    double ratio = std::sqrt(excess / (limit.limit * limit.limit - limit.floor * limit.floor));
    if (!std::isfinite(ratio)) ratio = 1e9;
    s.worst = std::max(s.worst, ratio);
    s.sum += std::log(std::max(ratio, 0.5));
  }
  return s;
}

Path PathJudge::described(const QuarterPath& path) const {
  const auto seconds = [&](std::size_t k) { return static_cast<double>(path.rests[k] * quantum); };
  Path out{seconds(0), {}, duration(path)};
  for (std::size_t k = 0; k < path.turns.size(); ++k) out.turns.push_back({path.turns[k].axis, 90.0 * path.turns[k].quarters, seconds(k + 1)});
  const Eigen::VectorXd sigma = sigma_of(knowledge(path));
  for (const Limit& limit : limits_)
    if (const double ratio = limit.sigma(sigma[limit.row]) / limit.limit; !(ratio <= out.worst))
      out.worst = ratio, out.worst_coefficient = limit.coefficient;
  return out;
}

}  // namespace imulab::hybrid
