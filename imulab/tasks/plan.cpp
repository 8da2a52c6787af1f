#include "imulab/tasks/plan.hpp"

#include "imulab/core/checkpoint_file.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/procedure.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
  session.imu.noise = NoiseTerms::full;  // flicker and walk, too
  if (task.noise) take_noise(session.imu, *task.noise);
  if (task.by_hand) session.rigs.front() = {};  // kind none
  return session;
}

/// The unit with white noise alone, which is what the search knows.
Session without_slow_noise(Session session) {
  NoiseModels noise = declared_noise(session.imu);
  noise.gyro.B = noise.gyro.K = noise.accel.B = noise.accel.K = 0;
  session.imu.gyro_noise = noise.gyro, session.imu.accel_noise = noise.accel;
  return session;
}

/// A part of each limit; less of a margin where the limit is near what no path reaches.
std::vector<Requirement> with_margin(std::vector<Requirement> requirements, double margin, const Session& unit, double turn_rate) {
  for (Requirement& r : requirements) {
    double least = 0;
    for (const CoefficientIndex index : r.coefficients) least = std::max(least, planning_method().plan.least_sigma(unit, index, turn_rate));
    r.limit = std::max(margin * r.limit, std::sqrt(least * r.limit));
  }
  return requirements;
}

/// Requirements that no path can meet are refused before the search.
void expect_reachable(const PathLimits& limits, const Session& unit) {
  for (const Requirement& r : limits.requirements)
    for (const CoefficientIndex index : r.coefficients)
      if (const double least = planning_method().plan.least_sigma(unit, index, limits.turn_rate); least >= r.limit)
        throw Unsupported(
            fmt::format("{} <= {:g} {}: no path makes {} better than {:.3g} {}; {} it{}", r.selector, r.limit / r.unit.size, r.unit.name,
                        coefficient(index).name, least / r.unit.size, r.unit.name,
                        coefficient(index).triad == Triad::accel ? "gravity and the cubic term limit" : "nonlinearity, at one rate, limits",
                        coefficient(index).triad == Triad::gyro || unit.site.given_gravity ? "" : "; a measured value of gravity is more certain"));
}

struct PlannedPath {
  TurnPath path;
  Session procedure;
  Prediction prediction;
  double worst = 1;         ///< ratio of a predicted sigma to its limit
  bool by_effects = false;  ///< without them the limits are met
};

/// Everything that a search depends on.
std::string identity_of(const PlanTask& task, const PathLimits& q) {
  std::vector<IdentityField> fields{{"procedure", sha256(procedure_text(procedure_of(task, 60, {})))},
                                    {"rest", q.rest ? fmt::format("{}", *q.rest) : "chosen"},
                                    {"within", q.time ? fmt::format("{}", *q.time) : "shortest"},
                                    {"turn_rate", fmt::format("{}", q.turn_rate)}};
  for (const RigAxis axis : q.axes) fields.emplace_back("axis", to_string(axis));
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex index : r.coefficients) fields.emplace_back("require", fmt::format("{} {}", coefficient(index).name, r.limit));
  return work_identity("plan", fields);
}

/// Tightens the limits of a search, which knows neither effects nor slow noise, by what these add along the path that it found; where that alone is
/// too much, by half: a longer path tells effects and coefficients better apart.
void allow_for_unsearched(std::vector<Requirement>& limits, const std::vector<Requirement>& required, const Prediction& with,
                          const Prediction& without) {
  constexpr double spare = 0.98;
  for (std::size_t i = 0; i < required.size(); ++i) {
    double added = 0;  // variance
    for (const CoefficientIndex index : required[i].coefficients)
      if (const double sigma = predicted(with, index).compared(); std::isfinite(sigma))
        added = std::max(added, sigma * sigma - std::pow(sigma_of(index, without.coefficients, without.sigma), 2));
    const double left = required[i].limit * required[i].limit - added;
    limits[i].limit = left > 0 ? std::min(limits[i].limit, spare * std::sqrt(left)) : 0.5 * limits[i].limit;
  }
}

/// `name`: of this search among those of a plan. `begin`, `part`: of the progress.
PlannedPath planned_path(const PlanTask& task, PathLimits question, const std::string& name, double begin, double part) {
  constexpr int most_rounds = 4;
  constexpr double nearer = 0.85;  // of the worst ratio, in twice the time, which lowers noise to 0.7: less is a floor that effects leave
  const std::vector<Requirement> requirements = question.requirements;
  PlannedPath out, first, before;
  for (int round = 0; round < most_rounds; ++round) {
    std::optional<Sharing> sharing = task.sharing;
    if (sharing) sharing->identity = identity_of(task, question);
    if (sharing && !sharing->checkpoint.empty()) sharing->checkpoint /= fmt::format("{}{}", name, round + 1);
    const auto progress = [&](int done) {
      if (task.progress) task.progress(begin + part * 0.01 * done);
    };
    out.path = planning_method().plan.design(question, procedure_of(task, 60, {}), progress, sharing ? &*sharing : nullptr);
    if (out.path.turns.empty()) throw Error("no turn and rest fit into the time; expected a longer time");
    out.procedure = procedure_of(task, out.path.first_rest, out.path.turns);
    out.prediction = predict(planning_method(), out.procedure, {.effects = task.effects, .advice = false});
    out.worst = 1;
    for (const Shortfall& s : shortfalls(out.prediction, requirements)) out.worst = std::max(out.worst, s.sigma / s.requirement.limit);
    if (out.worst == 1) break;
    if (round > 0 && out.path.duration > 2 * before.path.duration && out.worst > nearer * before.worst) break;
    if (round == 0) first = out;
    if (task.time || out.path.worst > 1) break;
    const Prediction without = predict(planning_method(), without_slow_noise(out.procedure), {.effects = false, .advice = false});
    allow_for_unsearched(question.requirements, requirements, out.prediction, without);
    before = out;
  }
  if (out.worst == 1) return out;
  const auto meets = [&](const PlannedPath& path) { return shortfalls(path.prediction, task.requirements).empty(); };
  if (!meets(out) || meets(first)) out = std::move(first);  // which would do without effects, where no path does with them
  if (task.effects)
    out.by_effects = shortfalls(predict(planning_method(), out.procedure, {.effects = false, .advice = false}), task.requirements).empty();
  return out;
}

/// The requirements that the path itself has to meet.
std::vector<Requirement> with_prior(const PlanTask& task) {
  std::vector<Requirement> left = left_to_reach(task.requirements, *task.prior);
  std::erase_if(left, [](const Requirement& r) { return zero_by_frame(r.coefficients.front()); });
  if (left.empty()) throw Error(fmt::format("{}: its units meet the requirements uncalibrated; expected tighter ones", task.prior->fleet));
  return left;
}

/// 1, 2, 3 and hand, or names.
std::vector<RigAxis> axes_of(const std::string& text) {
  using enum RigAxis;
  if (text == "1") return {outer};
  if (text == "2") return {middle, inner};
  if (text == "3" || text == "hand") return {outer, middle, inner};
  std::vector<RigAxis> axes;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    const std::size_t before = axes.size();
    for (const RigAxis axis : {outer, middle, inner})
      if (name == to_string(axis) && std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
    if (axes.size() == before) throw OptionError("axes", text + "; expected 1, 2, 3, hand, or names such as outer,inner");
    begin = end + 1;
  }
  std::sort(axes.begin(), axes.end());
  return axes;
}

std::string text_of(const PlannedProcedure& p) {
  const bool said = conclusion_of(p).verdict == Verdict::met;  // by the headline
  std::string text = said ? "" : fmt::format("{} turns in {}\n", p.path.turns.size(), text::minutes(p.path.duration));
  if (p.prior) text += prior_text(*p.prior) + "\n";
  return fmt::format("{}{}{}\n{}", text, text.empty() ? "" : "\n", path_table(p.path), prediction_table(p.prediction, p.requirements));
}

PlanSummary summary_of(const PlannedProcedure& p) { return {p.requirements, p.path, imulab::summary_of(p.prediction), p.prior, p.margin}; }

}  // namespace

Verb& declare(Verb& command, PlanOptions& o) {
  Verb& verb = command.verb(
      "plan", fmt::format("Find the shortest path that meets requirements: rotations and rests on a table or by hand ({}), or maneuvers of a drive",
                          planning_method().name));
  verb.option("--require LIMITS", o.require, "limits that the path must meet, as in \"gyro.matrix.off_diagonal <= 1 arcsec, accel.bias <= 1 ug\"")
      .required();
  std::vector<std::string> names;
  for (const Grade& of : grades()) names.emplace_back(of.name);
  verb.option("--grade GRADE", o.grade, "grade of the IMU's noise").one_of(names).show_default();
  verb.option("--noise FILE", o.noise, "noise.json: its white noise, flicker and random walk in place of the grade's").reads();
  verb.option("--margin FRACTION", o.margin, "the part of each limit to reach").in_range(0.1, 1.).show_default();
  verb.option("--latitude DEG", o.latitude_deg, "latitude of the site").in_range(-90, 90).show_default().called("latitude_deg");
  verb.option("--gravity G", o.gravity, "gravity in m/s^2, measured to 1e-5; absent: normal gravity, known to 3e-4").in_range(9.7, 9.9);
  verb.option("--axes AXES", o.axes, "the table's axes: 1 (outer, vertical), 2 (middle and inner), 3, or names such as outer,inner; hand: no table")
      .show_default();
  verb.option("--within SECONDS", o.within, "find the best path within this time, instead of the shortest path").in_range(60, longest_path);
  verb.option("--rest SECONDS", o.rest, "duration of each rest, whole seconds; absent: chosen for each").in_range(6, 600, true);
  verb.option("--mission FILE", o.mission, "add maneuvers to this drive with [[aid]]: figure eights, hard braking, slopes, rests")
      .reads()
      .of_command();
  effects_option(verb, o.effects);
  prior_option(verb, o.prior);
  verb.option("-o,--output FILE", o.output, "the procedure or mission to write; - for standard output in place of the table").writes().of_command();
  report_option(verb, o.report);
  sharing_options(verb, o.shared);
  json_option(verb, o.json);
  verb.example("imulab plan --require \"gyro.matrix.diagonal <= 10 ppm\" -o plan.toml");
  return verb;
}

PlanTask task_of(const PlanOptions& o) {
  PlanTask task{.requirements = errors_of_option("require", [&] { return parse_requirements(o.require); }),
                .grade = o.grade,
                .noise = o.noise,
                .margin = o.margin,
                .latitude = o.latitude_deg * unit::deg,
                .gravity = o.gravity,
                .axes = axes_of(o.axes),
                .by_hand = o.axes == "hand",
                .time = o.within,
                .rest = o.rest,
                .effects = o.effects == "table"};
  task.sharing = o.shared.sharing();
  task.prior = read_prior(o.prior);
  return task;
}

void add_prior(Prediction& prediction, const FleetPrior& prior) {
  std::erase_if(prediction.undetermined, [&](CoefficientIndex index) {
    if (!std::isfinite(relative_sigma(prior, index))) return false;
    const Eigen::Index n = prediction.sigma.size();
    prediction.coefficients.push_back(index);
    for (Eigen::VectorXd* of : {&prediction.sigma, &prediction.cramer_rao, &prediction.degrees_of_freedom}) {
      of->conservativeResize(n + 1);
      (*of)[n] = std::numeric_limits<double>::infinity();
    }
    return true;
  });
  prediction.remaining = {};
  for (std::size_t k = 0; k < prediction.coefficients.size(); ++k)
    for (Eigen::VectorXd* of : {&prediction.sigma, &prediction.cramer_rao}) {
      double& sigma = (*of)[static_cast<Eigen::Index>(k)];
      sigma = 1 / std::hypot(1 / sigma, 1 / relative_sigma(prior, prediction.coefficients[k]));
    }
}

AnswerOf<PlannedProcedure> plan_answer(const PlanTask& task, const std::string& written) {
  const auto p = std::make_shared<const PlannedProcedure>(plan(task));
  const Conclusion conclusion = conclusion_of(*p);
  return {{.json = [p] { return plan_json(summary_of(*p)); },
           .table = [p](bool) { return text_of(*p); },
           .page = [p, conclusion, written] { return plan_page(summary_of(*p), conclusion, written); },
           .shortcomings = shortcomings(*p),
           .conclusion = conclusion},
          p};
}

PlannedProcedure plan(const PlanTask& task) {
  PathLimits question;
  const Session unit = procedure_of(task, 60, {});
  question.requirements = task.prior ? with_prior(task) : task.requirements;
  question.axes = task.axes;
  question.turn_rate = task.by_hand ? hand_rate : TableProcedureOptions{}.turn_rate;
  question.rest = task.rest;
  question.time = task.time;
  planning_method().plan.expect_estimated(question.requirements, unit);
  expect_reachable(question, unit);
  question.requirements = with_margin(question.requirements, task.margin, unit, question.turn_rate);
  if (task.sharing && !task.sharing->checkpoint.empty())  // the folder is this plan's
    const CheckpointFile mark(task.sharing->checkpoint, identity_of(task, question), [](std::size_t, const std::string&) {});
  PlannedProcedure out;
  out.margin = task.margin;
  out.requirements = task.requirements;
  const bool compared = task.prior && !task.time;
  PlannedPath found = planned_path(task, question, "path", 0, compared ? 0.5 : 1);
  if (task.prior) out.prior = PriorEffect{task.prior->fleet, task.prior->units, std::numeric_limits<double>::quiet_NaN()};
  if (compared) {
    question.requirements = with_margin(task.requirements, task.margin, unit, question.turn_rate);
    PlannedPath without = planned_path(task, question, "without-prior", 0.5, 0.5);
    if (without.path.worst <= 1) out.prior->duration_without = without.path.duration;
    if (without.path.worst <= 1 && without.path.duration < found.path.duration) found = std::move(without);  // the search does not look at all paths
  }
  out.by_effects = found.by_effects;
  out.path = std::move(found.path), out.procedure = std::move(found.procedure), out.prediction = std::move(found.prediction);
  if (task.prior)
    add_prior(out.prediction, *task.prior);
  else
    out.prediction = predict(planning_method(), out.procedure, {.effects = task.effects, .sizes = true, .advice = false});
  out.prediction.missed = shortfalls(out.prediction, task.requirements);
  return out;
}

Conclusion conclusion_of(const PlannedProcedure& p) {
  const std::vector<RequirementResult> required = assess(p.prediction, p.requirements);
  double most = 0;
  for (const RequirementResult& r : required) most = std::max(most, r.reached / r.limit);
  Conclusion out = conclude(Verdict::none, "", required);
  out.requirements.clear();  // the table shows them
  if (out.verdict != Verdict::met) return out;
  constexpr double agreement = 1.01;  // of the margin that was asked for, and the path in whole seconds
  out.headline =
      fmt::format("{} turns in {}, uncertainties at most {:.2f} of what is required", p.path.turns.size(), text::minutes(p.path.duration), most);
  if (most > agreement * p.margin) out.headline += fmt::format("; no path was found that leaves the margin ({:g})", p.margin);
  return out;
}

std::string shortcomings(const PlannedProcedure& p) {
  const std::vector<Shortfall>& missed = p.prediction.missed;
  if (missed.empty()) return "";
  std::string text;
  const std::vector<CoefficientIndex>& undetermined = p.prediction.undetermined;
  for (const Shortfall& s : missed) {
    text += (text.empty() ? "" : "; ") + shortfall_text(s);
    const auto at = std::find(undetermined.begin(), undetermined.end(), s.coefficient) - undetermined.begin();
    if (!std::isfinite(s.sigma))
      text += fmt::format(", it stays at {:.3g} {}", p.prediction.remaining[at] / s.requirement.unit.size, s.requirement.unit.name);
  }
  if (p.by_effects)
    text += "; without the effects that such an IMU may have (docs/theory/effects.md) they are met: declare smaller ones if it is better";
  return fmt::format("no path was found that meets the requirements: {}", text);
}

}  // namespace imulab
