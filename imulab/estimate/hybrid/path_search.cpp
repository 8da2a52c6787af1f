#include "imulab/estimate/hybrid/path_search.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/recording/turn.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;

namespace {

constexpr int usual_quantum = 5;  // s
constexpr double quarter = std::numbers::pi / 2, turn_acceleration = default_acceleration_dps2 * unit::deg;
constexpr std::array<int, 4> quarter_turns{1, 2, -1, -2};

}  // namespace

PathJudge::PathJudge(const PathQuestion& q)
    : quantum(q.rest ? static_cast<int>(std::lround(*q.rest)) : usual_quantum), model_(q.unit), turn_rate_(q.turn_rate) {
  find_limits(q);
  const std::vector<Matrix3d>& attitudes = table_.attitudes();
  const int most = q.rest ? 1 : longest_rest / usual_quantum;  // in quanta
  turn_.resize(attitudes.size());
  rest_.resize(attitudes.size());
  parallel_for(attitudes.size(), [&](std::size_t k) {
    for (Index a = 0; a < 3; ++a)
      for (std::size_t t = 0; t < quarter_turns.size(); ++t)
        turn_[k][static_cast<std::size_t>(a)][t] =
            turn_information(model_, attitudes[k], {Vector3d::Unit(a), quarter_turns[t] * quarter, turn_rate_, turn_acceleration});
    const MotionInformation one = rest_information(model_, attitudes[k], {quantum});
    for (const std::size_t outermost : {0u, 1u}) {
      std::vector<MotionInformation>& rests = rest_[k][outermost];
      rests.push_back(rest_information(model_, attitudes[k], used_seconds(model_, quantum, outermost == 1)));
      for (int quanta = 2; quanta <= most; ++quanta) rests.push_back(joined(rests.back(), one));
    }
  });
}

void PathJudge::find_limits(const PathQuestion& q) {
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex coefficient : r.coefficients)
      for (Index row = 0; row < model_.size(); ++row) {  // none for the upper triangle of the accelerometers, which is zero in their frame
        const Index state = model_.constants[static_cast<std::size_t>(row)];
        if (model_.states.corrects(state) != coefficient) continue;
        // A coefficient begins to count as determined at half of its prior.
        limits_.push_back({row, coefficient, std::min(r.limit, 0.499 * model_.states.prior[state]), least_sigma(q.unit, coefficient, q.turn_rate),
                           nonlinear_sigma(q.unit, coefficient, q.turn_rate)});
      }
}

const MotionInformation& PathJudge::turn(const QuarterPose& pose, const QuarterTurn& turn) const {
  const auto [along, opposite] = table_.axis(pose, turn.axis);
  const auto angle = std::find(quarter_turns.begin(), quarter_turns.end(), opposite ? -turn.quarters : turn.quarters) - quarter_turns.begin();
  return turn_[table_.attitude(pose)][along][static_cast<std::size_t>(angle)];
}

const MotionInformation& PathJudge::rest(const QuarterPose& pose, int quanta, bool outermost) const {
  return rest_[table_.attitude(pose)][outermost ? 1 : 0][static_cast<std::size_t>(quanta - 1)];
}

double PathJudge::duration(const QuarterTurn& turn) const { return turn_duration(turn.quarters * quarter, turn_rate_, turn_acceleration); }

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
    if (limit.limit <= limit.floor) continue;  // no path can reach it
    const double excess = std::pow(limit.sigma(sigma[limit.row]), 2) - limit.floor * limit.floor;
    double ratio = std::sqrt(excess / (limit.limit * limit.limit - limit.floor * limit.floor));
    if (!std::isfinite(ratio)) ratio = 1e9;
    s.worst = std::max(s.worst, ratio);
    s.sum += std::log(std::max(ratio, 0.5));
  }
  return s;
}

TurnPath PathJudge::described(const QuarterPath& path) const {
  const auto seconds = [&](std::size_t k) { return static_cast<double>(path.rests[k] * quantum); };
  TurnPath out{seconds(0), {}, duration(path)};
  for (std::size_t k = 0; k < path.turns.size(); ++k) out.turns.push_back({path.turns[k].axis, 90.0 * path.turns[k].quarters, seconds(k + 1)});
  const Eigen::VectorXd sigma = sigma_of(knowledge(path));
  for (const Limit& limit : limits_)
    if (const double ratio = limit.sigma(sigma[limit.row]) / limit.limit; !(ratio <= out.worst))
      out.worst = ratio, out.worst_coefficient = limit.coefficient;
  return out;
}

namespace {

constexpr std::size_t width = 64;        // number of beginnings in the beam search
constexpr std::size_t first_turns = 40;  // longer paths need fewer beginnings
constexpr std::size_t patience = 40;     // largest number of turns that do not reduce the worst ratio by 5 %

/// The beginning of a path with equal rests.
struct Beginning {
  Knowledge knowledge;
  QuarterPose pose{};
  std::vector<QuarterTurn> turns;
  double duration = 0;
  Score score;
};

/// Returns the best beginnings: half by the sum of the logarithms, half by the worst ratio, each corrected for the effect of time on the noise.
std::vector<Beginning> best_of(std::vector<Beginning> all, std::size_t most, std::size_t limits) {
  std::vector<Beginning> out;
  const auto take = [&](auto key, std::size_t count) {
    const auto place = [&](const Beginning& b) { return grid_place(key(b)); };
    std::stable_sort(all.begin(), all.end(), [&](const Beginning& a, const Beginning& b) { return place(a) < place(b); });
    std::vector<Beginning> left;
    double last = -HUGE_VAL;
    for (Beginning& b : all) {
      const double value = place(b);
      if (value - last < 2) continue;  // a mirror image of the previous one is equally good
      last = value;
      (out.size() < count ? out : left).push_back(std::move(b));
    }
    all = std::move(left);
  };
  take([&](const Beginning& b) { return b.score.sum + 0.5 * static_cast<double>(limits) * std::log(b.duration); }, most / 2);
  take([](const Beginning& b) { return std::log(b.score.worst) + 0.5 * std::log(b.duration); }, most);
  return out;
}

/// Returns all beginnings extended by one move that are not longer than `longest`.
std::vector<Beginning> continued(const PathJudge& judge, const std::vector<Beginning>& beam, const std::vector<QuarterTurn>& moves, int rest,
                                 double longest) {
  std::vector<Beginning> next(beam.size() * moves.size());
  parallel_for(next.size(), [&](std::size_t k) {
    const Beginning& b = beam[k / moves.size()];
    const QuarterTurn& move = moves[k % moves.size()];
    const double duration = b.duration + judge.duration(move) + rest * judge.quantum;
    if (duration > longest) return;
    const QuarterPose pose = turned(b.pose, move);
    next[k] = {after(after(b.knowledge, judge.turn(b.pose, move)), judge.rest(pose, rest, false)), pose, b.turns, duration, {}};
    next[k].turns.push_back(move);
    next[k].score = judge.score(next[k].knowledge);
  });
  std::erase_if(next, [](const Beginning& b) { return b.turns.empty(); });
  return next;
}

}  // namespace

std::vector<Candidate> search_turns(const PathJudge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest, bool all_the_time) {
  std::vector<Candidate> found;
  std::vector<Beginning> beam{{after(judge.start(), judge.rest({}, rest, true)), {}, {}, static_cast<double>(rest * judge.quantum), {}}};
  double best = HUGE_VAL, least = HUGE_VAL, enough = HUGE_VAL;
  for (std::size_t depth = 0, of_least = 0; !beam.empty() && depth < of_least + patience; ++depth) {
    beam = best_of(continued(judge, beam, moves, rest, longest), depth < first_turns ? width : width / 4, judge.limits());
    double nearest = HUGE_VAL;
    for (const Beginning& b : beam) {
      const double merit = b.duration * b.score.worst * b.score.worst;
      nearest = std::min(nearest, b.duration);
      if (b.score.worst < 0.95 * least) {
        least = b.score.worst;
        of_least = depth;
      }
      const bool within = b.score.worst <= 1;
      const double of_those_within = all_the_time ? b.score.worst : b.duration;
      if (merit >= best && !(within && of_those_within < enough)) continue;
      best = std::min(best, merit);
      if (within) enough = std::min(enough, of_those_within);
      found.push_back({{b.turns, std::vector<int>(b.turns.size() + 1, rest)}, within ? of_those_within : merit, within});
    }
    if (beam.empty() || (!all_the_time && nearest > 1.1 * enough)) break;
  }
  return found;
}

}  // namespace imulab::hybrid
