#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/report/plan_page.hpp"
#include "imulab/rig/procedure.hpp"
#include "imulab/tasks/predict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

constexpr double hand_rate = 45 * unit::deg;  // rad/s: a quarter turn in three seconds

Session procedure_of(const PlanTask& task, double first_rest, const std::vector<TableTurn>& turns) {
  TableProcedureOptions table;
  table.latitude = task.latitude;
  table.grade = task.grade;
  if (task.by_hand) table.turn_rate = hand_rate;
  Session session = turns_procedure("plan", first_rest, turns, table);
  session.site.given_gravity = task.gravity;
  if (task.by_hand) session.rigs.front() = {};  // kind none
  return session;
}

/// Requirements that no path can meet are refused before the search.
void expect_reachable(const hybrid::PathQuestion& q) {
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex index : r.coefficients)
      if (const double least = least_sigma(q.unit, index, q.turn_rate); least >= r.limit)
        throw Unsupported(fmt::format(
            "{} <= {:g} {}: no path makes {} better than {:.3g} {}; {} it{}", r.selector, r.limit / r.unit.size, r.unit.name, coefficient(index).name,
            least / r.unit.size, r.unit.name,
            coefficient(index).triad == Triad::accel ? "gravity and the cubic term limit" : "nonlinearity, at one rate, limits",
            coefficient(index).triad == Triad::gyro || q.unit.procedure.site.given_gravity ? "" : "; a measured value of gravity is more certain"));
}

std::string minutes(double seconds) { return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60))); }

}  // namespace

PlannedProcedure plan(const PlanTask& task) {
  hybrid::PathQuestion question;
  question.requirements = task.requirements;
  question.unit = hybrid::plan_of(procedure_of(task, 60, {}));
  question.axes = task.axes;
  question.turn_rate = task.by_hand ? hand_rate : TableProcedureOptions{}.turn_rate;
  question.rest = task.rest;
  question.time = task.time;
  expect_estimated(question.requirements, question.unit);
  expect_reachable(question);
  PlannedProcedure out;
  out.timed = task.time.has_value();
  out.requirements = task.requirements;
  // The search and the prediction along the finished procedure agree to some parts in a thousand: what misses by no more is looked for again.
  constexpr double agreement = 1.02;
  constexpr int most_rounds = 3;
  for (int round = 0; round < most_rounds; ++round) {
    out.path = design_path(question, [&](int done) {
      if (task.progress) task.progress(0.01 * done);
    });
    if (out.path.turns.empty()) throw Error("no turn and rest fit into the time; expected a longer time");
    out.procedure = procedure_of(task, out.path.first_rest, out.path.turns);
    out.prediction = predict(hybrid::plan_of(out.procedure));
    out.missed = shortfalls(out.prediction, task.requirements);
    double worst = 1;
    for (const Shortfall& s : out.missed) worst = std::max(worst, s.sigma / s.requirement.limit);
    if (worst == 1 || worst > agreement || out.timed || out.path.worst > 1) break;
    for (Requirement& r : question.requirements) r.limit /= 1.01 * worst;
  }
  return out;
}

std::string plan_json(const PlannedProcedure& p) { return path_json(p.path, p.requirements, p.prediction, p.missed); }

std::string plan_text(const PlannedProcedure& p) {
  return fmt::format("{} turns in {}\n\n{}\n{}", p.path.turns.size(), minutes(p.path.duration), path_table(p.path),
                     prediction_table(p.prediction, p.requirements));
}

std::string plan_page(const PlannedProcedure& p) {
  PredictionSummary summary{.coefficients = p.prediction.coefficients,
                            .undetermined = p.prediction.undetermined,
                            .sigma = p.prediction.sigma,
                            .cramer_rao = p.prediction.cramer_rao,
                            .missed = p.missed};
  return plan_page(PlanSummary{p.requirements, p.path, std::move(summary)});
}

std::string shortcomings(const PlannedProcedure& p) {
  const auto open = std::find_if(p.missed.begin(), p.missed.end(), [](const Shortfall& s) { return !std::isfinite(s.sigma); });
  if (p.missed.empty() || (p.timed && open == p.missed.end())) return "";
  std::string text;
  const std::vector<CoefficientIndex>& undetermined = p.prediction.undetermined;
  for (const Shortfall& s : p.missed) {
    text += (text.empty() ? "" : "; ") + shortfall_text(s);
    const auto at = std::find(undetermined.begin(), undetermined.end(), s.coefficient) - undetermined.begin();
    if (!std::isfinite(s.sigma))
      text += fmt::format(", it stays at {:.3g} {}", p.prediction.remaining[at] / s.requirement.unit.size, s.requirement.unit.name);
  }
  return fmt::format("no path was found that meets the requirements: {}", text);
}

}  // namespace imulab
