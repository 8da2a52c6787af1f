#include "imulab/tasks/budget.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/aided/aided_budget.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/track.hpp"
#include "imulab/tasks/aid_files.hpp"
#include "imulab/tasks/content.hpp"
#include "imulab/tasks/navigation_figures.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace imulab {
namespace {

/// A rest shows the heading by the Earth's rate, which the gyros of such a unit do not resolve.
std::optional<std::string> hopeless_alignment(const ErrorBudget& b, const StartErrors& start) {
  if (!start.aligned_over) return std::nullopt;
  constexpr Eigen::Index heading = 8;
  const double sigma = std::hypot(b.mean(heading, 0), std::sqrt(b.covariance.front()(heading, heading)));
  if (sigma <= largest_heading_sigma) return std::nullopt;
  return fmt::format(
      "a rest does not show the heading to these gyros (error {:.2g} rad): what follows from it means nothing; give it, start = {{ aligned_over_s = "
      "..., "
      "heading_arcmin = ... }}, and use imulab navigate --heading",
      sigma);
}

/// Everything that the Monte Carlo depends on. What a grade or a system stands for is in the program.
std::string identity_of(const MissionFile& file, const ErrorSpecification& specification, const BudgetVerbOptions& o) {
  const std::filesystem::path folder = std::filesystem::path(o.mission).parent_path();
  std::vector<IdentityField> fields{{"mission", file.sha256}};
  for (const std::filesystem::path& named : file.files) fields.emplace_back("names", content_of(named));
  fields.emplace_back("grade", specification.grade.value_or(""));
  fields.emplace_back("system", specification.system.value_or(""));
  fields.emplace_back("calibration", specification.calibration ? content_of(folder / *specification.calibration) : "");
  fields.emplace_back("noise", specification.noise ? content_of(folder / *specification.noise) : "");
  fields.emplace_back("every", fmt::format("{}", o.every));
  fields.emplace_back("runs", fmt::format("{}", o.runs));
  fields.emplace_back("seed", fmt::format("{}", o.seed));
  return work_identity("budget", fields);
}

/// The mission's errors, or those that are named in their place.
ErrorSpecification sensors_of(const BudgetVerbOptions& o, const MissionFile& file) {
  if (!o.grade && !o.system && !o.calibration) {
    if (!file.errors) throw Error(o.mission + ": no errors; expected [errors], or a grade, a system or a calibration");
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

ErrorSpecification specification_of(const BudgetVerbOptions& o, const MissionFile& file) {
  ErrorSpecification s = sensors_of(o, file);
  if (!o.noise) return s;
  s.noise = std::filesystem::absolute(*o.noise).string();  // it replaces the noise terms, whatever else is named
  for (TriadErrors* const triad : {&s.gyro, &s.accel}) triad->N = triad->B = triad->K = triad->Q = std::nullopt, triad->R = std::nullopt;
  return s;
}

/// The aids' own rates and sizes are those of their simulation; what they measured does not matter.
MissionBudget budget_with_aids(const MissionFile& file, const ErrorSpecification& specification, const BudgetVerbOptions& o,
                               ErrorSourcesReading reading) {
  MissionBudget out;
  out.warnings = std::move(reading.warnings);
  if (specification.vertical != VerticalChannel::free)
    out.warnings.push_back(
        fmt::format("{}: vertical = \"{}\" and its barometer do not count beside [[aid]], which give the height; expected [[aid]] of kind barometer",
                    o.mission, to_string(specification.vertical)));
  if (const std::string beyond = beyond_aided_budget(reading.sources); !beyond.empty())
    out.warnings.push_back(fmt::format("{}: {}: not part of a budget with aids, whose filter has no state for it", o.mission, beyond));
  const motion::Trajectory motion = errors_at(o.mission, [&] { return trajectory_of(file.mission); });
  out.motion = nominal_motion(motion, 1 / file.mission.rate);
  Session session;
  simulate_aids(session, file.mission.aids, motion, o.seed);
  errors_at(o.mission, [&] { out.budget = aided_budget(out.motion, reading.sources, session.aids, {.output_interval = o.every}); });
  if (auto warning = large_angles(out.budget)) out.warnings.push_back(std::move(*warning)), out.doubtful = true;
  return out;
}

MissionBudget mission_budget(const MissionFile& file, const ErrorSpecification& specification, const BudgetVerbOptions& o,
                             std::optional<Sharing> sharing, const std::function<void(double)>& progress) {
  if (!(o.every > 0)) throw Error(fmt::format("{} s between outputs; expected a positive number", o.every));
  ErrorSourcesReading reading = read_error_sources(specification, o.mission);
  if (!file.mission.aids.empty()) return budget_with_aids(file, specification, o, std::move(reading));
  MissionBudget out;
  out.warnings = std::move(reading.warnings);
  out.motion = nominal_motion(errors_at(o.mission, [&] { return trajectory_of(file.mission); }), 1 / file.mission.rate);
  StrapdownOptions strapdown;
  strapdown.vertical = specification.vertical;
  if (!(sharing && sharing->part)) out.budget = error_budget(out.motion, reading.sources, {.strapdown = strapdown, .output_interval = o.every});
  if (sharing) sharing->identity = identity_of(file, specification, o);
  if (o.runs > 0) {
    out.monte_carlo = error_monte_carlo(
        out.motion, reading.sources, {.strapdown = strapdown, .output_interval = o.every, .runs = o.runs, .seed = o.seed},
        [&](std::uint64_t done) {
          if (progress) progress(static_cast<double>(done) / static_cast<double>(o.runs));
        },
        sharing ? &*sharing : nullptr);
    out.runs = o.runs;
  }
  if (auto warning = hopeless_alignment(out.budget, reading.sources.start)) out.warnings.push_back(std::move(*warning)), out.doubtful = true;
  if (auto warning = large_angles(out.budget)) out.warnings.push_back(std::move(*warning)), out.doubtful = out.doubtful || !out.monte_carlo;
  return out;
}

/// Where the noise of the sensors comes from.
std::string noise_origin(const ErrorSpecification& s) {
  if (s.noise) return std::filesystem::path(*s.noise).filename().string();
  return s.grade ? "the grade" : s.system ? "the system" : "the mission";
}

/// "flight.toml, grade navigation, noise of the grade"
std::string titled(const std::string& mission, const MissionBudget& b) {
  return mission + (b.grade.empty() ? "" : ", grade " + b.grade) + ", noise of " + b.noise;
}

std::string page_of(const MissionBudget& b, const std::string& mission, std::vector<std::string> warnings, const Conclusion& conclusion) {
  warnings.insert(warnings.end(), b.warnings.begin(), b.warnings.end());
  return budget_page(
      BudgetReport{.mission = titled(mission, b),
                   .summary = {.budget = b.budget, .monte_carlo = b.monte_carlo, .runs = b.runs, .track = report::thinned_track(b.motion.states)},
                   .warnings = std::move(warnings),
                   .conclusion = conclusion,
                   .curves = loss_curves(b.budget, conclusion.requirements)});
}

}  // namespace

Verb& declare(Verb& command, BudgetVerbOptions& o) {
  Verb& verb = command.verb("budget", "Position, velocity and attitude errors on a motion, by source");
  verb.option("mission", o.mission, "the mission file: a motion and its [errors]").reads();
  VerbOption& grade = verb.option("--grade GRADE", o.grade, "sensors of this grade in place of the mission's; several, with commas, are compared");
  VerbOption& system = verb.option("--system NAME", o.system, "sensors of this airliner system, in place of the mission's").excludes(grade);
  verb.option("--calibration FILE", o.calibration,
              "errors that this calibration leaves, in place of the mission's; noise and turn-on biases are still the mission's")
      .reads()
      .excludes(grade)
      .excludes(system);
  verb.option("--noise FILE", o.noise, "noise.json: its terms in place of the mission's or grade's noise").reads();
  verb.option("--require LIMITS", o.require,
              "limits, as in \"CEP <= 1 nmi/h\" at the end or \"CEP <= 200 m at 600 s\"; also RMS, 95 %, vertical, velocity, heading; exit code 1 "
              "otherwise");
  verb.option("--runs", o.runs, "number of Monte Carlo runs, full integrations with drawn errors; 0 for none").show_default().in_range(0., 1e9);
  seed_option(verb, o.seed);
  verb.option("--every SECONDS", o.every, "time between rows of the files").in_range(1e-3, 1e6).show_default();
  sharing_options(verb, o.shared);
  verb.option("-o,--output FOLDER", o.output,
              "the folder to create, with errors over time: total.csv, sources.csv, monte_carlo.csv, runs.csv; with --part the part's file")
      .creates()
      .of_command();
  report_option(verb, o.report);
  verb.option("--catalogue", o.catalogue, "list grades and systems").of_command();
  allow_undetermined_option(verb, o.allow_undetermined);
  json_option(verb, o.json);
  verb.option("-v,--verbose", o.verbose, "also print velocity, attitude and the Monte Carlo by axis").of_command();
  verb.example("imulab budget flight.toml --grade navigation");
  verb.example("imulab budget flight.toml --require \"CEP <= 1 nmi/h\"");
  verb.example("imulab budget flight.toml --grade strategic,tactical --report grades.html");
  return verb;
}

AnswerOf<MissionBudget> budget_answer(const MissionFile& file, const BudgetVerbOptions& o, const Tell& tell,
                                      const std::function<void(double)>& progress, const std::string& allow) {
  if (o.shared.is_divided() && o.runs == 0) throw OptionError("part", "divides a Monte Carlo; expected --runs");
  if (!file.mission.aids.empty() && (o.shared.is_divided() || (o.runs > 0 && o.shared.verb != nullptr && o.shared.verb->at("--runs").given)))
    throw OptionError(
        "runs", "a mission with [[aid]] has no Monte Carlo: its budget is the covariance of the filter that navigate --aided runs; expected no runs");
  std::optional<Sharing> sharing = o.shared.sharing();
  if (o.require) errors_of_option("require", [&] { expect_budget_limits(*o.require); });
  const ErrorSpecification specification = specification_of(o, file);
  bool doubtful_calibration = false;
  std::vector<std::string> told;
  if (const auto& name = specification.calibration) {
    const std::filesystem::path path = std::filesystem::path(o.mission).parent_path() / *name;
    const Calibration calibration = read_calibration(path);
    told = expect_usable(calibration, o.calibration.value_or(path.string()), o.allow_undetermined, allow);
    std::ranges::for_each(told, tell);
    doubtful_calibration = !doubt_about(calibration, "").empty();
  }
  const auto made = std::make_shared<MissionBudget>(mission_budget(file, specification, o, std::move(sharing), progress));
  made->grade = specification.grade.value_or(specification.system.value_or("")), made->noise = noise_origin(specification);
  made->doubtful = made->doubtful || doubtful_calibration;
  const std::shared_ptr<const MissionBudget> b = made;
  const auto required =
      o.require ? errors_of_option("require", [&] { return assess(b->budget, b->monte_carlo, *o.require); }) : std::vector<RequirementResult>();
  const Conclusion conclusion = conclude(b->doubtful ? Verdict::doubtful : Verdict::none, budget_headline(b->budget, b->monte_carlo), required);
  return {{.json = [b] { return budget_json(b->budget, b->monte_carlo, b->motion.states, b->grade, b->noise); },
           .table = [b](bool details) { return budget_table(b->budget, b->monte_carlo, details); },
           .page = [b, mission = std::filesystem::path(o.mission).filename().string(), conclusion,
                    told] { return page_of(*b, mission, told, conclusion); },
           .warnings = b->warnings,
           .told = told,
           .shortcomings = missed_requirements(conclusion),
           .conclusion = conclusion},
          b};
}

void write_budget(const std::filesystem::path& path, const MissionBudget& b) {
  NewFolder folder(path);
  write_whole(folder.path() / "total.csv", total_csv(b.budget));
  write_whole(folder.path() / "sources.csv", sources_csv(b.budget));
  if (b.monte_carlo) {
    write_whole(folder.path() / "monte_carlo.csv", distribution_csv(*b.monte_carlo));
    write_whole(folder.path() / "runs.csv", runs_csv(*b.monte_carlo));
  }
  folder.commit();
}

}  // namespace imulab
