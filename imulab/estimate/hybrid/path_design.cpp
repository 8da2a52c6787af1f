#include "imulab/estimate/hybrid/path_design.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/hybrid/path_search.hpp"
#include "imulab/model/relative_uncertainty.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::hybrid {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double helps = 1 - 1e-6;  // a smaller decrease does not count

/// Returns the indices of finite values, the smallest first.
std::vector<std::size_t> order_of(const std::vector<double>& values) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) order.push_back(k);
  const auto place = [&](std::size_t k) { return grid_place(std::log(values[k])); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  return order;
}

/// Returns the worst ratios if the rests change one at a time by `change` quanta; infinite if a rest cannot change.
std::vector<double> one_by_one(const PathJudge& judge, const QuarterPath& path, int change) {
  std::vector<double> out(path.rests.size(), infinite);
  parallel_for(out.size(), [&](std::size_t k) {
    const int rest = path.rests[k] + change;
    if (rest * judge.quantum < shortest_rest || rest * judge.quantum > longest_rest) return;
    QuarterPath changed = path;
    changed.rests[k] = rest;
    out[k] = judge.worst(changed);
  });
  return out;
}

/// Shortens rests (and lengthens as many others if `exchanged`), first many at a time, then fewer, while `accepts` returns true.
QuarterPath shortened(const PathJudge& judge, QuarterPath path, std::size_t most, bool exchanged,
                      const std::function<bool(const QuarterPath&)>& accepts) {
  while (most > 0) {
    std::vector<std::size_t> longer;
    if (exchanged) longer = order_of(one_by_one(judge, path, 1));
    const std::vector<std::size_t> shorter = order_of(one_by_one(judge, path, -1));
    most = std::min(most, exchanged ? std::min(longer.size(), shorter.size()) : shorter.size());
    for (bool done = false; most > 0 && !done; most = done ? most : most / 2) {
      QuarterPath trial = path;
      for (std::size_t k = 0; k < most; ++k) {
        if (exchanged) ++trial.rests[longer[k]];
        --trial.rests[shorter[k]];
      }
      done = accepts(trial);
      if (done) path = std::move(trial);
    }
  }
  return path;
}

/// Lengthens rests until the requirements are met, then shortens rests as long as they are.
QuarterPath shortest(const PathJudge& judge, QuarterPath path, double longest) {
  double worst = judge.worst(path);
  while (worst > 1 && judge.duration(path) < longest) {
    const std::vector<double> longer = one_by_one(judge, path, 1);
    const std::vector<std::size_t> order = order_of(longer);
    if (order.empty() || longer[order.front()] > worst * helps) break;
    for (std::size_t k = 0; k < std::max<std::size_t>(1, order.size() / 4); ++k) ++path.rests[order[k]];
    worst = judge.worst(path);
  }
  if (worst > 1) return path;
  const std::size_t all = path.rests.size();
  return shortened(judge, std::move(path), all, false, [&](const QuarterPath& trial) { return !(judge.worst(trial) > 1); });
}

/// Distributes the remaining time to the rests that need it, then exchanges time between rests.
QuarterPath best_in(const PathJudge& judge, QuarterPath path, double time) {
  while (judge.duration(path) + judge.quantum <= time) {
    const std::vector<std::size_t> order = order_of(one_by_one(judge, path, 1));
    if (order.empty()) break;
    const auto room = static_cast<std::size_t>((time - judge.duration(path)) / judge.quantum);
    for (std::size_t k = 0; k < std::min({room, order.size(), std::size_t{4}}); ++k) ++path.rests[order[k]];
  }
  double worst = judge.worst(path);
  const std::size_t half = path.rests.size() / 2;
  return shortened(judge, std::move(path), half, true, [&](const QuarterPath& trial) {
    const double now = judge.worst(trial);
    return now < worst * helps && (worst = now, true);
  });
}

/// Replaces one turn by another as long as this improves the path.
QuarterPath polished(const PathJudge& judge, QuarterPath path, const std::vector<QuarterTurn>& moves, double longest) {
  double worst = judge.worst(path);
  const std::size_t rounds = 8000 / (path.turns.size() * path.turns.size() + 1);  // the work of a round is proportional to the square
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<double> value(path.turns.size() * moves.size(), infinite);
    const auto changed = [&](std::size_t k) {
      QuarterPath trial = path;
      trial.turns[k / moves.size()] = moves[k % moves.size()];
      return trial;
    };
    parallel_for(value.size(), [&](std::size_t k) {
      const QuarterPath trial = changed(k);
      if (judge.duration(trial) <= longest) value[k] = judge.worst(trial);
    });
    const std::vector<std::size_t> order = order_of(value);
    if (order.empty() || value[order.front()] >= worst * helps) break;
    path = changed(order.front());
    worst = value[order.front()];
  }
  return path;
}

/// Returns the best candidates within the limits and outside, for further examination.
std::vector<QuarterPath> best_candidates(std::vector<Candidate> found, std::size_t of_each) {
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return grid_place(std::log(a.merit)) < grid_place(std::log(b.merit)); });
  std::vector<QuarterPath> chosen;
  for (const bool within : {true, false}) {
    std::size_t count = 0;
    for (const Candidate& c : found)
      if (c.within == within && count++ < of_each) chosen.push_back(c.path);
  }
  return chosen;
}

/// Converts paths to numbers for a checkpoint, and back.
void add(std::vector<double>& numbers, const QuarterPath& path) {
  numbers.push_back(static_cast<double>(path.turns.size()));
  for (const QuarterTurn& turn : path.turns) numbers.insert(numbers.end(), {static_cast<double>(turn.axis), static_cast<double>(turn.quarters)});
  numbers.insert(numbers.end(), path.rests.begin(), path.rests.end());
}

std::string bytes_of(const std::vector<double>& numbers) { return imulab::bytes_of(numbers.data(), numbers.size()); }

class Numbers {
 public:
  explicit Numbers(const std::string& bytes) : numbers_(bytes.size() / sizeof(double)) { read_numbers(bytes, numbers_.data(), numbers_.size()); }
  bool end() const { return at_ == numbers_.size(); }
  double next() {
    if (end()) throw Error("a path in the checkpoint ends too early: another version of imulab wrote it");
    return numbers_[at_++];
  }
  QuarterPath path() {
    QuarterPath path;
    const int turns = whole(0, 100000);
    for (int k = 0; k < turns; ++k) {
      const auto axis = static_cast<RigAxis>(whole(0, 2));
      path.turns.push_back({axis, whole(-2, 2)});
    }
    for (int k = 0; k <= turns; ++k) path.rests.push_back(whole(0, 100000));
    return path;
  }

 private:
  int whole(int least, int most) {
    const double number = next();
    if (!(number >= least && number <= most)) throw Error("a path in the checkpoint has a number out of range: another version of imulab wrote it");
    return static_cast<int>(number);
  }

  std::vector<double> numbers_;
  std::size_t at_ = 0;
};

/// Runs one step of the search.
void for_each_path(const SharedWork& work, const Sharing* sharing, const char* step) {
  if (sharing == nullptr) return for_each(work);
  Sharing own = *sharing;
  if (!own.checkpoint.empty()) own.checkpoint /= step;
  for_each(work, &own);
}

}  // namespace

double nonlinear_sigma(const Plan& unit, CoefficientIndex index, double turn_rate) {
  const Coefficient& c = coefficient(index);
  if (!is_scale(c) || !unit.terms.wanted.empty()) return 0;
  const kernel::PriorSizes& sizes = unit.terms.priors.sizes;
  if (c.triad == Triad::accel) return sizes.accel.cubic * unit.place.gravity * unit.place.gravity;
  return std::hypot(sizes.gyro.quadratic * turn_rate, sizes.gyro.cubic * turn_rate * turn_rate);
}

double least_sigma(const Plan& unit, CoefficientIndex index, double turn_rate) {
  const Coefficient& c = coefficient(index);
  const bool as_gravity = c.triad == Triad::accel && is_scale(c);
  return std::hypot(nonlinear_sigma(unit, index, turn_rate), as_gravity ? unit.place.gravity_sigma / unit.place.gravity : 0);
}

namespace {

void check(const PathLimits& limits) {
  std::vector<std::string> problems;
  for (const Requirement& r : limits.requirements)
    for (const std::string& problem : problems_of(r)) problems.push_back(problem);
  if (limits.axes.empty()) problems.emplace_back("no axes to turn about; expected one or more");
  for (const auto& [name, value] :
       {std::pair{"turn_rate", std::optional(limits.turn_rate)}, std::pair{"time", limits.time}, std::pair{"rest", limits.rest}})
    if (value && !(*value > 0 && std::isfinite(*value))) problems.push_back(fmt::format("{}: {} is not allowed; expected more than 0", name, *value));
  throw_problems("the path", problems);
}

}  // namespace

TurnPath design_path(const PathQuestion& q, const std::function<void(int)>& progress, const Sharing* sharing) {
  check(q);
  const auto report = [&](double part) {
    if (progress) progress(static_cast<int>(100 * part));
  };
  const PathJudge judge(q);
  const std::vector<QuarterTurn> moves = quarter_turns(q.axes);
  const double longest = q.time.value_or(longest_path);
  const std::vector<int> rests = q.rest ? std::vector<int>{1} : std::vector<int>{2, 4, 8, 16};
  std::vector<Candidate> found;
  const auto search_part = [&](std::size_t k) {
    std::vector<double> numbers;
    for (const Candidate& c : search_turns(judge, moves, rests[k], longest, q.time.has_value())) {
      numbers.insert(numbers.end(), {c.merit, c.within ? 1. : 0.});
      add(numbers, c.path);
    }
    return bytes_of(numbers);
  };
  const auto take_candidates = [&](std::size_t, const std::string& bytes) {
    for (Numbers numbers(bytes); !numbers.end();) {
      const double merit = numbers.next();
      const bool within = numbers.next() > 0;
      found.push_back({numbers.path(), merit, within});
    }
  };
  const auto part_of = [](std::size_t done, std::size_t all) { return static_cast<double>(done) / static_cast<double>(all); };
  for_each_path({rests.size(), search_part, take_candidates, [&](std::size_t done) { report(0.7 * part_of(done, rests.size())); }}, sharing, "turns");

  const std::vector<QuarterPath> chosen = best_candidates(std::move(found), q.rest ? 8 : q.time ? 4 : 2);
  const auto rested = [&](QuarterPath path) {
    if (q.rest) return path;
    return q.time ? best_in(judge, std::move(path), longest) : shortest(judge, std::move(path), longest);
  };
  const auto refine = [&](std::size_t k) {
    QuarterPath path = rested(chosen[k]);
    path = rested(polished(judge, path, moves, q.time ? longest : judge.duration(path)));
    std::vector<double> numbers{judge.worst(path)};
    add(numbers, path);
    return bytes_of(numbers);
  };
  QuarterPath best{{}, {1}};
  double worst = infinite;
  const auto better = [&](const QuarterPath& path, double now) {
    if (!q.time && (now <= 1) != (worst <= 1)) return now <= 1;
    if (!q.time && now <= 1 && judge.duration(path) != judge.duration(best)) return judge.duration(path) < judge.duration(best);
    return now < worst * helps;
  };
  const auto take_best = [&](std::size_t, const std::string& bytes) {
    Numbers numbers(bytes);
    const double now = numbers.next();
    QuarterPath path = numbers.path();
    if (!better(path, now)) return;
    best = std::move(path);
    worst = now;
  };
  for_each_path({chosen.size(), refine, take_best, [&](std::size_t done) { report(0.7 + 0.3 * part_of(done, chosen.size())); }}, sharing, "rests");
  return judge.described(best);
}

}  // namespace imulab::hybrid
