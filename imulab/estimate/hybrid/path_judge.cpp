#include "imulab/estimate/hybrid/path_judge.hpp"

#include "imulab/core/units.hpp"
#include "imulab/recording/turn.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::hybrid {

namespace {

constexpr int usual_quantum = 5;  // s

}  // namespace

PathJudge::PathJudge(const PathQuestion& q)
    : model_(q.unit),
      quantum(q.rest ? static_cast<int>(std::lround(*q.rest)) : usual_quantum),
      parts(model_, q.turn_rate, default_acceleration_dps2 * unit::deg, quantum, q.rest ? 1 : longest_rest / usual_quantum) {
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex coefficient : r.coefficients)
      for (Eigen::Index row = 0; row < model_.size(); ++row) {  // none for those of an accelerometer's upper triangle: zero in its frame
        const Eigen::Index state = model_.constants[static_cast<std::size_t>(row)];
        if (model_.states.corrects(state) != coefficient) continue;
        // Half of the prior is where a coefficient begins to count as determined.
        limits_.push_back({row, coefficient, std::min(r.limit, 0.499 * model_.states.prior[state]), least_sigma(q.unit, coefficient)});
      }
}

Knowledge PathJudge::knowledge(const QuarterPath& path) const {
  QuarterPose pose{};
  Knowledge now = after(start(), parts.rest(pose, path.rests.front(), true));
  for (std::size_t k = 0; k < path.turns.size(); ++k) {
    now = after(now, parts.turn(pose, path.turns[k]));
    pose = parts.turned(pose, path.turns[k]);
    now = after(now, parts.rest(pose, path.rests[k + 1], k + 1 == path.turns.size()));
  }
  return now;
}

Score PathJudge::score(const Knowledge& knowledge) const {
  const Eigen::VectorXd sigma = sigma_of(knowledge);
  Score s;
  for (const Limit& limit : limits_) {
    if (limit.limit <= limit.floor) continue;  // out of reach of any path
    const double excess = sigma[limit.row] * sigma[limit.row] - limit.floor * limit.floor;
    double ratio = std::sqrt(excess / (limit.limit * limit.limit - limit.floor * limit.floor));
    if (!std::isfinite(ratio)) ratio = 1e9;
    s.worst = std::max(s.worst, ratio);
    s.sum += std::log(std::max(ratio, 0.5));
  }
  return s;
}

double PathJudge::duration(const QuarterPath& path) const {
  double sum = 0;
  for (const int rest : path.rests) sum += rest * quantum;
  for (const QuarterTurn& turn : path.turns) sum += parts.duration(turn);
  return sum;
}

Path PathJudge::described(const QuarterPath& path) const {
  const auto rest = [&](std::size_t k) { return static_cast<double>(path.rests[k] * quantum); };
  Path out{rest(0), {}, duration(path)};
  for (std::size_t k = 0; k < path.turns.size(); ++k) out.turns.push_back({path.turns[k].axis, 90.0 * path.turns[k].quarters, rest(k + 1)});
  const Eigen::VectorXd sigma = sigma_of(knowledge(path));
  for (const Limit& limit : limits_)
    if (const double ratio = sigma[limit.row] / limit.limit; !(ratio <= out.worst)) out.worst = ratio, out.worst_coefficient = limit.coefficient;
  return out;
}

}  // namespace imulab::hybrid
