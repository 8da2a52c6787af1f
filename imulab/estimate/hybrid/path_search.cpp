#include "imulab/estimate/hybrid/path_search.hpp"

#include "imulab/core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::hybrid {

namespace {

constexpr std::size_t width = 64;        // of the beam
constexpr std::size_t first_turns = 40;  // beyond them, fewer beginnings are enough
constexpr std::size_t patience = 40;     // turns without which the worst ratio falls by 5 %

/// The beginning of a path with equal rests.
struct Beginning {
  Knowledge knowledge;
  QuarterPose pose{};
  std::vector<QuarterTurn> turns;
  double duration = 0;
  Score score;
};

/// The best of each kind: half of them by the sum of the logarithms, half by the worst ratio, each times the effect of the time spent on the noise.
std::vector<Beginning> best_of(std::vector<Beginning> all, std::size_t most, std::size_t limits) {
  std::vector<Beginning> out;
  const auto take = [&](auto key, std::size_t count) {
    std::stable_sort(all.begin(), all.end(), [&](const Beginning& a, const Beginning& b) { return key(a) < key(b); });
    std::vector<Beginning> left;
    double last = -HUGE_VAL;
    for (Beginning& b : all) {
      const double value = key(b);
      if (value - last < 1e-7) continue;  // a mirror image of the previous one: equally good
      last = value;
      (out.size() < count ? out : left).push_back(std::move(b));
    }
    all = std::move(left);
  };
  take([&](const Beginning& b) { return b.score.sum + 0.5 * static_cast<double>(limits) * std::log(b.duration); }, most / 2);
  take([](const Beginning& b) { return std::log(b.score.worst) + 0.5 * std::log(b.duration); }, most);
  return out;
}

/// All beginnings with one move more that are not longer than `longest`.
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

std::vector<Candidate> search_turns(const PathJudge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest) {
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
      if (merit >= best && !(within && b.duration < enough)) continue;
      best = std::min(best, merit);
      if (within) enough = std::min(enough, b.duration);
      found.push_back({{b.turns, std::vector<int>(b.turns.size() + 1, rest)}, within ? b.duration : merit, within});
    }
    if (beam.empty() || nearest > 1.1 * enough) break;
  }
  return found;
}

}  // namespace imulab::hybrid
