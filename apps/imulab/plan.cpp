// imulab plan --require ...
#include "apps/imulab/command.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/io/result/prediction.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/report/plan_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct Options {
  std::string require, grade = "navigation", axes = "3", report;
  double latitude_deg = 45;
  std::optional<double> gravity, time, rest;
  std::optional<std::string> output;
  bool json = false;
};

constexpr double hand_rate = 45 * unit::deg;  // rad/s: a quarter turn in three seconds

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
    if (axes.size() == before) throw Error(fmt::format("--axes: {}; expected 1, 2, 3, hand, or names such as outer,inner", text));
    begin = end + 1;
  }
  std::sort(axes.begin(), axes.end());
  return axes;
}

Session procedure_of(const Options& options, double first_rest, const std::vector<TableTurn>& turns) {
  TableProcedureOptions table;
  table.latitude = options.latitude_deg * unit::deg;
  table.grade = options.grade;
  if (options.axes == "hand") table.turn_rate = hand_rate;
  Session session = turns_procedure("plan", first_rest, turns, table);
  session.file = "--grade";  // where an unknown one was given
  session.site.given_gravity = options.gravity;
  if (options.axes == "hand") session.rigs.front() = {};  // kind none
  return session;
}

/// Requirements that no path can meet are refused before the search.
void expect_reachable(const hybrid::PathQuestion& q) {
  for (const Requirement& r : q.requirements)
    for (const CoefficientIndex index : r.coefficients)
      if (const double least = least_sigma(q.unit, index); least >= r.limit)
        throw Unsupported(fmt::format("{} <= {:g} {}: {} is as uncertain as gravity, {:.3g} {}{}", r.selector, r.limit / r.unit.size, r.unit.name,
                                      coefficient(index).name, least / r.unit.size, r.unit.name,
                                      q.unit.procedure.site.given_gravity ? "" : "; --gravity gives a measured value"));
}

std::string minutes(double seconds) { return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60))); }

void run(const Options& options) {
  hybrid::PathQuestion question;
  question.requirements = errors_at("--require", [&] { return parse_requirements(options.require); });
  if (options.json && options.output == "-") throw Error("--json: standard output has the procedure; expected -o FILE");
  question.unit = hybrid::plan_of(procedure_of(options, 60, {}));
  question.axes = axes_of(options.axes);
  question.turn_rate = options.axes == "hand" ? hand_rate : TableProcedureOptions{}.turn_rate;
  question.rest = options.rest;
  question.time = options.time;
  errors_at("--require", [&] { expect_estimated(question.requirements, question.unit); });
  expect_reachable(question);

  const hybrid::Path path = [&] {
    Progress progress("planning", 100);
    return design_path(question, [&](int done) { progress.report(done); });
  }();
  if (path.turns.empty()) throw Error("--time: no turn and rest fit into it; expected a longer time");
  const Session procedure = procedure_of(options, path.first_rest, path.turns);
  const hybrid::Prediction p = predict(hybrid::plan_of(procedure));
  const std::vector<Shortfall> missed = shortfalls(p, question.requirements);
  if (options.output) write_whole(*options.output, procedure_text(procedure));
  if (options.json)
    print_json(path_json(path, question.requirements, p, missed));
  else if (options.output != "-")
    print(fmt::format("{} turns in {}\n\n{}\n{}", path.turns.size(), minutes(path.duration), path_table(path),
                      prediction_table(p, question.requirements)));
  if (!options.report.empty()) {
    PredictionSummary summary{
        .coefficients = p.coefficients, .undetermined = p.undetermined, .sigma = p.sigma, .cramer_rao = p.cramer_rao, .missed = missed};
    write_whole(options.report, plan_page({question.requirements, path, std::move(summary)}));
  }
  const auto open = std::find_if(missed.begin(), missed.end(), [](const Shortfall& s) { return !std::isfinite(s.sigma); });
  if (missed.empty() || (options.time && open == missed.end())) return;
  std::string text;
  for (const Shortfall& s : missed) {
    text += (text.empty() ? "" : "; ") + shortfall_text(s);
    const auto at = std::find(p.undetermined.begin(), p.undetermined.end(), s.coefficient) - p.undetermined.begin();
    if (!std::isfinite(s.sigma)) text += fmt::format(", it stays at {:.3g} {}", p.remaining[at] / s.requirement.unit.size, s.requirement.unit.name);
  }
  throw Unsupported(fmt::format("no path was found that meets the requirements: {}", text));
}

}  // namespace

void add_plan(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("plan", "Find the shortest sequence of turns and rests with which the hybrid method meets requirements");
  verb.option("--require LIMITS", o->require, "requirements, as in \"gyro.matrix.off_diagonal <= 1 arcsec, accel.offset <= 1 ug\"").required();
  verb.option("--grade GRADE", o->grade, "grade of the IMU's noise: strategic, navigation, tactical, mems, mems-30g").show_default();
  verb.option("--latitude", o->latitude_deg, "latitude of the site, degrees").in_range(-90, 90).show_default();
  verb.option("--gravity", o->gravity, "gravity measured to 1e-5 m/s^2; if absent, normal gravity, known to 3e-4").in_range(9.7, 9.9);
  verb.option("--axes AXES", o->axes, "axes of the table: 1 (outer, vertical), 2 (middle and inner), 3, hand, or names such as outer,inner")
      .show_default();
  verb.option("--time N", o->time, "find the best path within this many seconds instead of the shortest").in_range(60, hybrid::longest_path);
  verb.option("--rest", o->rest, "duration of every rest in whole seconds; if absent, each is chosen").in_range(6, 600, true);
  verb.option("-o,--output FILE", o->output, "the procedure to write; - for standard output in place of the table").writes();
  add_report_option(verb, o->report);
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab plan --require \"gyro.matrix.diagonal <= 10 ppm\" -o plan.toml");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
