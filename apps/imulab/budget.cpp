// imulab budget SPEC
#include "imulab/tasks/budget.hpp"

#include "apps/imulab/checkpoint.hpp"
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/budget.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct Options {
  std::string mission, folder, report;
  std::optional<std::string> grade, system, calibration, noise;
  std::uint64_t runs = 200, seed = 1;
  double every = 10;
  bool catalogue = false, json = false, allow_undetermined = false, verbose = false;
  CheckpointOptions shared;
};

void run(const Options& o) {
  if (o.catalogue) return print(grade_catalogue());
  if (o.mission.empty()) throw Error("mission: expected the file of a mission, or --catalogue");
  const MissionFile file = read_mission(o.mission);
  for (const std::filesystem::path& named : file.files) will_read(named);
  BudgetTask task{o.mission, o.grade, o.system, o.calibration, o.noise, o.runs, o.seed, o.every};
  task.checkpoint = o.shared.checkpoint();
  const ErrorSpecification specification = specification_of(task, file);
  if (const auto& name = specification.calibration) {
    const std::filesystem::path path = std::filesystem::path(o.mission).parent_path() / *name;
    expect_usable(read_calibration(path), path.string(), o.allow_undetermined);
  }
  const MissionBudget budget = [&] {
    Progress progress("Monte Carlo");
    task.progress = [&progress](double part) { progress.report(part); };
    return mission_budget(file, specification, task);
  }();
  if (o.shared.silent()) return;
  if (!o.folder.empty()) write_budget(o.folder, budget);
  if (!o.report.empty()) write_whole(o.report, budget_page(budget, std::filesystem::path(o.mission).filename().string()));
  for (const std::string& text : budget.warnings) warn(text);
  o.json ? print_json(budget_json(budget)) : print(budget_table(budget.budget, budget.monte_carlo, o.verbose));
}

}  // namespace

void add_budget(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("budget", "Position, velocity and attitude errors on a motion, by source");
  verb.option("mission", o->mission, "the mission file: a motion and its [errors]").reads();
  Option grade = verb.option("--grade GRADE", o->grade, "sensors of this grade, in place of the mission's");
  Option system = verb.option("--system NAME", o->system, "sensors of this airliner system, in place of the mission's");
  Option calibration = verb.option("--calibration FILE", o->calibration,
                                   "the errors that this calibration leaves, in place of the mission's; the noise is still the mission's own")
                           .reads();
  verb.option("--noise FILE", o->noise, "noise.json of a log at rest: its terms in place of the mission's or grade's").reads();
  grade.excludes(system).excludes(calibration);
  system.excludes(calibration);
  verb.option("--runs", o->runs, "number of Monte Carlo runs; 0 for none").show_default().in_range(0., 1e7);
  verb.option("--seed", o->seed, "random seed; the same seed gives the same result").show_default();
  verb.option("--every", o->every, "seconds between rows of the files").in_range(1e-3, 1e6).show_default();
  add_checkpoint_options(verb, o->shared);
  verb.option("-o,--output FOLDER", o->folder, "the folder to create: total.csv, sources.csv, monte_carlo.csv over time, runs.csv").creates();
  add_report_option(verb, o->report);
  verb.flag("--catalogue", o->catalogue, "list the available grades and systems");
  add_allow_undetermined(verb, o->allow_undetermined);
  verb.flag("--json", o->json, "print the result as JSON");
  verb.flag("-v,--verbose", o->verbose, "print also velocity, attitude and the Monte Carlo by axis");
  verb.example("imulab budget flight.toml --grade navigation");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
