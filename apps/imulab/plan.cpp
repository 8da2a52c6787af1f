// imulab plan --require ...
#include "apps/imulab/command.hpp"
#include "apps/imulab/hybrid_table.hpp"
#include "imulab/analysis/path_design.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/io/terminal.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct Options {
  std::string require, grade = "navigation", axes = "3";
  double latitude_deg = 45;
  std::optional<double> gravity, minutes, rest;
  std::optional<std::string> output;
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
    if (axes.size() == before) throw Error(fmt::format("--axes: {}: 1, 2, 3, hand, or names such as outer,inner were expected", text));
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
  session.file = "--grade";  // where an unknown one was written
  session.site.given_gravity = options.gravity;
  if (options.axes == "hand") session.rigs.front() = {};  // kind none
  return session;
}

/// What no path can reach, said before one is looked for.
void expect_reachable(const PathQuestion& q) {
  for (const Requirement& r : q.requirements)
    for (const int index : r.coefficients)
      if (const double least = least_sigma(q.unit, index); least >= r.limit)
        throw Unsupported(fmt::format("{} <= {:g} {}: {} is as uncertain as gravity, {:.3g} {}{}", r.selector, r.limit / r.unit.size, r.unit.name,
                                      coefficient_table()[static_cast<std::size_t>(index)].name, least / r.unit.size, r.unit.name,
                                      q.unit.procedure.site.given_gravity ? "" : "; --gravity gives a measured value"));
}

std::string minutes(double seconds) { return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60))); }

void print_path(const Path& path) {
  fmt::print("rest {:g} s\n", path.first_rest);
  const std::vector<std::string> words = in_words(path.turns);
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    fmt::print("{:>3}  {:<6} {:>+5g} deg  rest {:>3g} s   {}\n", k + 1, to_string(path.turns[k].axis), path.turns[k].angle_deg, path.turns[k].rest,
               words[k]);
}

void run(const Options& options) {
  PathQuestion question;
  question.requirements = parse_requirements(options.require);
  question.unit = hybrid_plan(procedure_of(options, 60, {}));
  question.axes = axes_of(options.axes);
  question.turn_rate = options.axes == "hand" ? hand_rate : TableProcedureOptions{}.turn_rate;
  question.rest = options.rest;
  if (options.minutes) question.time = *options.minutes * 60;
  expect_estimated(question.requirements, question.unit);
  expect_reachable(question);

  const Path path = [&] {
    Progress progress("planning, %", 100);
    return design_path(question, [&](int done) { progress.report(static_cast<std::uint64_t>(done)); });
  }();
  if (path.turns.empty()) throw Error("--time: no turn and rest fit into it: a longer time was expected");
  const Session procedure = procedure_of(options, path.first_rest, path.turns);
  const HybridPrediction p = predict(hybrid_plan(procedure));
  if (options.output == "-") {
    fmt::print("{}", procedure_text(procedure));
  } else {
    if (options.output) write_whole(*options.output, procedure_text(procedure));
    fmt::print("{} turns in {}\n\n", path.turns.size(), minutes(path.duration));
    print_path(path);
    fmt::print("\n");
    print_hybrid_table(p, question.requirements);
  }
  const std::vector<Shortfall> missed = shortfalls(p, question.requirements);
  const auto open = std::find_if(missed.begin(), missed.end(), [](const Shortfall& s) { return !std::isfinite(s.sigma); });
  if (missed.empty() || (options.minutes && open == missed.end())) return;
  std::string text;
  for (const Shortfall& s : missed) {
    text += (text.empty() ? "" : "; ") + text_of_hybrid(s);
    const auto at = std::find(p.undetermined.begin(), p.undetermined.end(), s.coefficient) - p.undetermined.begin();
    if (!std::isfinite(s.sigma)) text += fmt::format(", it stays at {:.3g} {}", p.remaining[at] / s.requirement.unit.size, s.requirement.unit.name);
  }
  throw Unsupported(fmt::format("no path was found that meets the requirements: {}", text));
}

/// A number within limits, in words.
std::function<std::string(const std::string&)> between(double low, double high, bool whole, const char* what) {
  return [=](const std::string& text) -> std::string {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(text, value) && value >= low && value <= high && (!whole || value == std::floor(value));
    return number ? "" : fmt::format("{}: {} from {:g} to {:g} was expected", text, what, low, high);
  };
}

}  // namespace

void add_plan(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("plan", "The shortest turns and rests by which the hybrid method reaches the required uncertainties");
  verb->add_option("--require", o->require, "requirements, as in \"gyro.matrix.off_diagonal <= 1 arcsec, accel.offset <= 1 ug\"")->required();
  verb->add_option("--grade", o->grade, "the unit's noise: strategic, navigation, tactical, mems, mems-30g")->capture_default_str();
  verb->add_option("--latitude", o->latitude_deg, "degrees")->check(between(-90, 90, false, "degrees"))->capture_default_str();
  verb->add_option("--gravity", o->gravity, "m/s^2, measured to 1e-5; else normal gravity, to 3e-4")->check(between(9.7, 9.9, false, "m/s^2"));
  verb->add_option("--axes", o->axes, "what turns: 1 (outer, vertical), 2 (middle and inner), 3, hand, or names such as outer,inner")
      ->capture_default_str();
  verb->add_option("--time", o->minutes, "minutes; the best for them in place of the shortest")
      ->check(between(1, longest_path / 60, false, "minutes"));
  verb->add_option("--rest", o->rest, "seconds of every rest, whole; else each is chosen")->check(between(6, 600, true, "whole seconds"));
  verb->add_option("-o,--output", o->output, "the procedure, as TOML; - for standard output in place of the table");
  verb->callback([o] { run(*o); });
}

}  // namespace imulab::command
