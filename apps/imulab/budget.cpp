// imulab budget SPEC
#include "imulab/navigation/budget/budget.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/error_sources.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/result/budget.hpp"
#include "imulab/io/result/grades.hpp"
#include "imulab/io/session/mission.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/report/budget_page.hpp"
#include "imulab/report/track.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>

namespace imulab::command {

ErrorSources mission_errors(const ErrorSpecification& specification, const std::string& mission) {
  const ErrorSourcesReading reading = read_error_sources(specification, mission);
  for (const std::string& text : reading.warnings) warn(text);
  return reading.sources;
}

namespace {

struct Options {
  std::string mission, folder, report;
  std::optional<std::string> grade, system, calibration, noise;
  std::uint64_t runs = 200, seed = 1;
  double every = 10;
  bool catalogue = false, json = false, allow_undetermined = false, verbose = false;
};

/// Above a tenth of a radian, products of errors are some percent of the errors.
void warn_of_large_angles(const ErrorBudget& b) {
  constexpr double largest = 0.1;
  for (std::size_t i = 0; i < b.time.size(); ++i)
    for (Eigen::Index q = 6; q < budget_quantities; ++q)
      if (std::hypot(b.mean(q, static_cast<Eigen::Index>(i)), std::sqrt(b.covariance[i](q, q))) > largest)
        return warn(fmt::format("an attitude error exceeds {1:g} rad from {0:g} s on; the linear figures are rough; rely on the Monte Carlo",
                                b.time[i], largest));
}

/// The mission's errors, or those that the command line names in their place.
ErrorSpecification named_specification(const Options& o, const MissionFile& file) {
  if (!o.grade && !o.system && !o.calibration) {
    if (!file.errors) throw Error(o.mission + ": no errors; expected [errors], or --grade, --system or --calibration");
    return *file.errors;
  }
  ErrorSpecification s;
  if (file.errors) s.start = file.errors->start, s.barometer = file.errors->barometer, s.vertical = file.errors->vertical;
  s.grade = o.grade;
  s.system = o.system;
  if (o.calibration) s.calibration = std::filesystem::absolute(*o.calibration).string();
  if (o.calibration && file.errors)  // a calibration contains neither the noise nor the turn-on bias
    for (auto [to, from] : {std::pair{&s.gyro, &file.errors->gyro}, {&s.accel, &file.errors->accel}})
      to->N = from->N, to->B = from->B, to->K = from->K, to->Q = from->Q, to->R = from->R, to->turn_on = from->turn_on;
  return s;
}

/// An analysis replaces the noise terms, whatever else is named.
ErrorSpecification specification_of(const Options& o, const MissionFile& file) {
  ErrorSpecification s = named_specification(o, file);
  if (!o.noise) return s;
  s.noise = std::filesystem::absolute(*o.noise).string();
  for (TriadErrors* const triad : {&s.gyro, &s.accel}) triad->N = triad->B = triad->K = triad->Q = std::nullopt, triad->R = std::nullopt;
  return s;
}

void run(const Options& o) {
  if (o.catalogue) return print(grade_catalogue());
  if (o.mission.empty()) throw Error("mission: expected the file of a mission, or --catalogue");
  const MissionFile file = read_mission(o.mission);
  for (const std::filesystem::path& named : file.files) will_read(named);
  const ErrorSpecification specification = specification_of(o, file);
  if (const auto& name = specification.calibration) {
    const std::filesystem::path path = std::filesystem::path(o.mission).parent_path() / *name;
    expect_usable(read_calibration(path), path.string(), o.allow_undetermined);
  }
  const ErrorSources sources = mission_errors(specification, o.mission);
  const motion::NominalMotion motion = nominal_motion(errors_at(o.mission, [&] { return trajectory_of(file.mission); }), 1 / file.mission.rate);
  StrapdownOptions strapdown;
  strapdown.vertical = specification.vertical;
  std::optional<NewFolder> folder;
  if (!o.folder.empty()) folder.emplace(o.folder);
  const ErrorBudget budget = error_budget(motion, sources, {.strapdown = strapdown, .output_interval = o.every});
  std::optional<ErrorDistribution> sampled;
  if (o.runs > 0) {
    Progress progress("Monte Carlo", static_cast<double>(o.runs));
    sampled = error_monte_carlo(motion, sources, {.strapdown = strapdown, .output_interval = o.every, .runs = o.runs, .seed = o.seed},
                                [&](std::uint64_t done) { progress.report(static_cast<double>(done)); });
  }
  if (folder) {
    write_whole(folder->path() / "total.csv", total_csv(budget));
    write_whole(folder->path() / "sources.csv", sources_csv(budget));
    if (sampled) {
      write_whole(folder->path() / "monte_carlo.csv", distribution_csv(*sampled));
      write_whole(folder->path() / "runs.csv", runs_csv(*sampled));
    }
    folder->commit();
  }
  if (!o.report.empty())
    write_whole(o.report,
                budget_page({.mission = std::filesystem::path(o.mission).filename().string(),
                             .summary = {.budget = budget, .monte_carlo = sampled, .runs = o.runs, .track = report::thinned_track(motion.states)}}));
  warn_of_large_angles(budget);
  o.json ? print_json(budget_json(budget, sampled, motion.states)) : print(budget_table(budget, sampled, o.verbose));
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
