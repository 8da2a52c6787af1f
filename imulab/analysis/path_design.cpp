#include "imulab/analysis/path_design.hpp"

#include "imulab/analysis/path_parts.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/estimate/hybrid_course.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/recording/turn.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr std::size_t first_turns = 40;                               // beyond them, what works is known
constexpr std::size_t patience = 40;                                  // turns without which the worst ratio falls by 5 %
constexpr int shortest_rest = 10, longest_rest = 300, quantum_s = 5;  // s

/// A path in quarter turns and quanta of rest; rests[0] is before the first turn.
struct Course {
  std::vector<QuarterTurn> turns;
  std::vector<int> rests;
};

/// Of the part of sigma that data can make smaller, sqrt(sigma^2 - floor^2), to what is required of it: the worst ratio, which is at most 1 where
/// sigma is within its limit, and the sum of the logarithms: how far there is to go where most are open.
struct Score {
  double worst = 0, sum = 0;
};

class Judge {
 public:
  explicit Judge(const PathQuestion& q)
      : quantum(q.rest ? static_cast<int>(std::lround(*q.rest)) : quantum_s),
        layout_(hybrid_layout(q.unit.terms, q.unit.site.latitude_sigma > 0)),
        prior_(prior_of(q.unit)),
        model_(information_model(q.unit, layout_, prior_)),
        parts(model_, q.turn_rate, default_acceleration_dps2 * unit::deg, quantum, q.rest ? 1 : longest_rest / quantum_s) {
    const std::vector<int> of_state = corrected_coefficients(layout_);
    for (const Requirement& r : q.requirements)
      for (const int coefficient : r.coefficients) {
        const auto state = std::find(of_state.begin(), of_state.end(), coefficient) - of_state.begin();
        const auto row = std::find(model_.constants.begin(), model_.constants.end(), state);
        if (row == model_.constants.end()) continue;  // of an accelerometer's upper triangle: zero in its frame
        const double floor = least_sigma(q.unit, coefficient);
        // Half of the prior is where a coefficient begins to count as determined.
        limits_.push_back({row - model_.constants.begin(), coefficient, std::min(r.limit, 0.499 * prior_[state]), floor});
      }
  }

  Score score(const Knowledge& knowledge) const {
    const VectorXd sigma = sigma_of(knowledge);
    Score s;
    for (const Limit& limit : limits_) {
      if (limit.limit <= limit.floor) continue;  // out of reach of any path
      const double excess = sigma[limit.row] * sigma[limit.row] - limit.floor * limit.floor;
      const double ratio = std::sqrt(excess / (limit.limit * limit.limit - limit.floor * limit.floor));
      s.worst = std::max(s.worst, std::isfinite(ratio) ? ratio : 1e9);
      s.sum += std::log(std::max(std::isfinite(ratio) ? ratio : 1e9, 0.5));
    }
    return s;
  }

  Knowledge start() const { return unknown(model_, prior_); }

  Knowledge knowledge(const Course& course) const {
    TablePose pose{};
    Knowledge now = after(start(), parts.rest(pose, course.rests.front(), true));
    for (std::size_t k = 0; k < course.turns.size(); ++k) {
      now = after(now, parts.turn(pose, course.turns[k]));
      pose = parts.turned(pose, course.turns[k]);
      now = after(now, parts.rest(pose, course.rests[k + 1], k + 1 == course.turns.size()));
    }
    return now;
  }
  Score score(const Course& course) const { return score(knowledge(course)); }

  /// The coefficient whose sigma is the largest of its limit.
  void name_worst(const Course& course, Path& path) const {
    const VectorXd sigma = sigma_of(knowledge(course));
    for (const Limit& limit : limits_)
      if (const double ratio = sigma[limit.row] / limit.limit; !(ratio <= path.worst)) path.worst = ratio, path.worst_coefficient = limit.coefficient;
  }

  double duration(const Course& course) const {
    double sum = 0;
    for (const int rest : course.rests) sum += rest * quantum;
    for (const QuarterTurn& turn : course.turns) sum += parts.duration(turn);
    return sum;
  }

  double limits() const { return static_cast<double>(limits_.size()); }

  const int quantum;

 private:
  struct Limit {
    Index row;
    int coefficient;
    double limit, floor;
  };
  static VectorXd prior_of(const HybridPlan& plan) {
    const Recording none;
    return begin_course({none, {}, plan.site, plan.noise, SensorModel{}, {}}, plan.terms).prior;
  }

  HybridLayout layout_;
  VectorXd prior_;
  InformationModel model_;
  std::vector<Limit> limits_;

 public:
  const PathParts parts;
};

/// A beginning of a path, all its rests alike.
struct Beginning {
  Knowledge knowledge;
  TablePose pose{};
  std::vector<QuarterTurn> turns;
  double duration = 0;
  Score score;
};

struct Candidate {
  Course course;
  double merit;  ///< the less the better: the time that the requirements would take if rests and turns were lengthened alike
  bool within;   ///< the limits
};

std::vector<QuarterTurn> moves_of(const std::vector<RigAxis>& axes) {
  std::vector<QuarterTurn> moves;
  for (const RigAxis axis : axes)
    for (const int quarters : {1, 2, -1, -2}) moves.push_back({axis, quarters});
  return moves;
}

/// The best of each kind: half of them by the sum of the logarithms, half by the worst ratio, each times what the time spent does to noise.
std::vector<Beginning> best_of(std::vector<Beginning> all, std::size_t width, double limits) {
  std::vector<Beginning> out;
  const auto take = [&](auto key, std::size_t count) {
    std::stable_sort(all.begin(), all.end(), [&](const Beginning& a, const Beginning& b) { return key(a) < key(b); });
    std::vector<Beginning> left;
    double last = -std::numeric_limits<double>::infinity();
    for (Beginning& b : all) {
      const double value = key(b);
      if (value - last < 1e-7) continue;  // a mirror image of the one before: as good
      last = value;
      (out.size() < count ? out : left).push_back(std::move(b));
    }
    all = std::move(left);
  };
  take([&](const Beginning& b) { return b.score.sum + 0.5 * limits * std::log(b.duration); }, width / 2);
  take([](const Beginning& b) { return std::log(b.score.worst) + 0.5 * std::log(b.duration); }, width);
  return out;
}

/// Beam search over turns, with every rest `rest` quanta long.
void search(const Judge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest, std::size_t width, std::vector<Candidate>& found,
            const std::function<void(double)>& progress) {
  const double rest_s = rest * judge.quantum;
  Beginning start{after(judge.start(), judge.parts.rest({}, rest, true)), {}, {}, rest_s, {}};
  std::vector<Beginning> beam{std::move(start)};
  double best = std::numeric_limits<double>::infinity(), least = best, enough = best;
  for (std::size_t depth = 0, of_least = 0; !beam.empty() && depth < of_least + patience; ++depth) {
    std::vector<Beginning> next(beam.size() * moves.size());
    tbb::parallel_for(std::size_t{0}, next.size(), [&](std::size_t k) {
      const Beginning& b = beam[k / moves.size()];
      const QuarterTurn& move = moves[k % moves.size()];
      const double duration = b.duration + judge.parts.duration(move) + rest_s;
      if (duration > longest) return;
      const TablePose pose = judge.parts.turned(b.pose, move);
      next[k] = {after(after(b.knowledge, judge.parts.turn(b.pose, move)), judge.parts.rest(pose, rest, false)), pose, b.turns, duration, {}};
      next[k].turns.push_back(move);
      next[k].score = judge.score(next[k].knowledge);
    });
    std::erase_if(next, [](const Beginning& b) { return b.turns.empty(); });
    beam = best_of(std::move(next), depth < first_turns ? width : width / 4, judge.limits());
    double nearest = std::numeric_limits<double>::infinity();
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
    progress(std::min(1.0, nearest / std::min(longest, 1.5 * best)));
  }
}

/// Scores of the course with the rests changed one at a time, by `change` quanta; infinite where a rest cannot.
std::vector<double> one_by_one(const Judge& judge, const Course& course, int change) {
  std::vector<double> out(course.rests.size(), std::numeric_limits<double>::infinity());
  tbb::parallel_for(std::size_t{0}, out.size(), [&](std::size_t k) {
    const int rest = course.rests[k] + change;
    if (rest * judge.quantum < shortest_rest || rest * judge.quantum > longest_rest) return;
    Course changed = course;
    changed.rests[k] = rest;
    out[k] = judge.score(changed).worst;
  });
  return out;
}

std::vector<std::size_t> order_of(const std::vector<double>& values) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

/// Longer rests until the requirements are met, then shorter ones as long as they are.
Course shortest(const Judge& judge, Course course, double longest) {
  double worst = judge.score(course).worst;
  while (worst > 1 && judge.duration(course) < longest) {
    const std::vector<double> longer = one_by_one(judge, course, 1);
    const std::vector<std::size_t> order = order_of(longer);
    if (order.empty() || longer[order.front()] > worst * (1 - 1e-6)) break;
    const std::size_t most = std::max<std::size_t>(1, order.size() / 4);
    for (std::size_t k = 0; k < most; ++k) ++course.rests[order[k]];
    worst = judge.score(course).worst;
  }
  if (worst > 1) return course;
  for (std::size_t most = course.rests.size(); most > 0;) {
    const std::vector<std::size_t> order = order_of(one_by_one(judge, course, -1));
    bool done = false;
    for (most = std::min(most, order.size()); most > 0 && !done; most = done ? most : most / 2) {
      Course trial = course;
      for (std::size_t k = 0; k < most; ++k) --trial.rests[order[k]];
      if (judge.score(trial).worst > 1) continue;
      course = std::move(trial);
      done = true;
    }
  }
  return course;
}

/// What time is left goes to the rests that need it, and then from rest to rest.
Course best_in(const Judge& judge, Course course, double time) {
  while (judge.duration(course) + judge.quantum <= time) {
    const std::vector<std::size_t> order = order_of(one_by_one(judge, course, 1));
    if (order.empty()) break;
    const auto room = static_cast<std::size_t>((time - judge.duration(course)) / judge.quantum);
    for (std::size_t k = 0; k < std::min({room, order.size(), std::size_t{4}}); ++k) ++course.rests[order[k]];
  }
  double worst = judge.score(course).worst;
  for (std::size_t most = course.rests.size() / 2; most > 0;) {
    const std::vector<std::size_t> longer = order_of(one_by_one(judge, course, 1)), shorter = order_of(one_by_one(judge, course, -1));
    bool done = false;
    for (most = std::min({most, longer.size(), shorter.size()}); most > 0 && !done; most = done ? most : most / 2) {
      Course trial = course;
      for (std::size_t k = 0; k < most; ++k) ++trial.rests[longer[k]], --trial.rests[shorter[k]];
      const double now = judge.score(trial).worst;
      if (now >= worst * (1 - 1e-6)) continue;
      worst = now;
      course = std::move(trial);
      done = true;
    }
  }
  return course;
}

/// One turn in another's place, or none, as long as it helps.
Course polished(const Judge& judge, Course course, const std::vector<QuarterTurn>& moves, double longest) {
  double worst = judge.score(course).worst;
  const std::size_t rounds = 8000 / (course.turns.size() * course.turns.size() + 1);  // a round's work goes with the square
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<double> value(course.turns.size() * moves.size(), std::numeric_limits<double>::infinity());
    const auto changed = [&](std::size_t k) {
      Course trial = course;
      trial.turns[k / moves.size()] = moves[k % moves.size()];
      return trial;
    };
    tbb::parallel_for(std::size_t{0}, value.size(), [&](std::size_t k) {
      const Course trial = changed(k);
      if (judge.duration(trial) <= longest) value[k] = judge.score(trial).worst;
    });
    const std::vector<std::size_t> order = order_of(value);
    if (order.empty() || value[order.front()] >= worst * (1 - 1e-6)) break;
    course = changed(order.front());
    worst = value[order.front()];
  }
  return course;
}

Path path_of(const Judge& judge, const Course& course) {
  Path path{static_cast<double>(course.rests.front() * judge.quantum), {}, judge.duration(course), 0, -1};
  judge.name_worst(course, path);
  for (std::size_t k = 0; k < course.turns.size(); ++k)
    path.turns.push_back({course.turns[k].axis, 90.0 * course.turns[k].quarters, static_cast<double>(course.rests[k + 1] * judge.quantum)});
  return path;
}

}  // namespace

double least_sigma(const HybridPlan& unit, int coefficient) {
  const Coefficient& c = coefficient_table()[static_cast<std::size_t>(coefficient)];
  return c.triad == Triad::accel && c.term == Term::matrix && c.row == c.column ? unit.site.gravity_sigma / unit.site.gravity : 0;
}

Path design_path(const PathQuestion& q, const std::function<void(int)>& progress) {
  const std::size_t width = 64, refined = q.rest ? 8 : 2;
  const auto report = [&](double part) {
    if (progress) progress(static_cast<int>(100 * part));
  };
  const Judge judge(q);
  const std::vector<QuarterTurn> moves = moves_of(q.axes);
  const double longest = q.time.value_or(longest_path);
  const std::vector<int> rests = q.rest ? std::vector<int>{1} : std::vector<int>{2, 4, 8, 16};
  std::vector<Candidate> found;
  for (std::size_t k = 0; k < rests.size(); ++k)
    search(judge, moves, rests[k], longest, width, found,
           [&](double part) { report(0.7 * (static_cast<double>(k) + part) / static_cast<double>(rests.size())); });
  // The best of both kinds are looked at closer.
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.merit < b.merit; });
  std::vector<Candidate> chosen;
  for (const bool within : {true, false}) {
    std::size_t count = 0;
    for (const Candidate& c : found)
      if (c.within == within && count++ < refined) chosen.push_back(c);
  }

  Course best{{}, {1}};
  double worst = std::numeric_limits<double>::infinity();
  const auto better = [&](const Course& a, double worst_a) {
    if (!q.time && (worst_a <= 1) != (worst <= 1)) return worst_a <= 1;
    if (!q.time && worst_a <= 1 && judge.duration(a) != judge.duration(best)) return judge.duration(a) < judge.duration(best);
    return worst_a < worst;
  };
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const auto rested = [&](Course course) {
      if (q.rest) return course;
      return q.time ? best_in(judge, std::move(course), longest) : shortest(judge, std::move(course), longest);
    };
    Course course = rested(chosen[k].course);
    course = rested(polished(judge, course, moves, q.time ? longest : judge.duration(course)));
    if (const double now = judge.score(course).worst; better(course, now)) {
      best = std::move(course);
      worst = now;
    }
    report(0.7 + 0.3 * static_cast<double>(k + 1) / static_cast<double>(chosen.size()));
  }
  return path_of(judge, best);
}

}  // namespace imulab
