#include "imulab/tasks/budget.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/track.hpp"
#include "imulab/tasks/content.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

namespace imulab {
namespace {

/// Above a tenth of a radian, products of errors are some percent of the errors.
std::optional<std::string> large_angles(const ErrorBudget& b) {
  constexpr double largest = 0.1;
  for (std::size_t i = 0; i < b.time.size(); ++i)
    for (Eigen::Index q = 6; q < budget_quantities; ++q)
      if (std::hypot(b.mean(q, static_cast<Eigen::Index>(i)), std::sqrt(b.covariance[i](q, q))) > largest)
        return fmt::format("an attitude error exceeds {1:g} rad from {0:g} s on; the linear figures are rough; rely on the Monte Carlo", b.time[i],
                           largest);
  return std::nullopt;
}

/// Everything that the Monte Carlo depends on. What a grade or a system stands for is in the program.
std::string identity_of(const MissionFile& file, const ErrorSpecification& specification, const BudgetTask& task) {
  const std::filesystem::path folder = std::filesystem::path(task.mission).parent_path();
  std::vector<IdentityField> fields{{"mission", file.sha256}};
  for (const std::filesystem::path& named : file.files) fields.emplace_back("names", content_of(named));
  fields.emplace_back("grade", specification.grade.value_or(""));
  fields.emplace_back("system", specification.system.value_or(""));
  fields.emplace_back("calibration", specification.calibration ? content_of(folder / *specification.calibration) : "");
  fields.emplace_back("noise", specification.noise ? content_of(folder / *specification.noise) : "");
  fields.emplace_back("every", fmt::format("{}", task.every));
  fields.emplace_back("runs", fmt::format("{}", task.runs));
  fields.emplace_back("seed", fmt::format("{}", task.seed));
  return work_identity("budget", fields);
}

/// The mission's errors, or those that are named in their place.
ErrorSpecification sensors_of(const BudgetTask& o, const MissionFile& file) {
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

}  // namespace

ErrorSpecification specification_of(const BudgetTask& task, const MissionFile& file) {
  ErrorSpecification s = sensors_of(task, file);
  if (!task.noise) return s;
  s.noise = std::filesystem::absolute(*task.noise).string();  // it replaces the noise terms, whatever else is named
  for (TriadErrors* const triad : {&s.gyro, &s.accel}) triad->N = triad->B = triad->K = triad->Q = std::nullopt, triad->R = std::nullopt;
  return s;
}

MissionBudget mission_budget(const MissionFile& file, const ErrorSpecification& specification, const BudgetTask& task) {
  if (!(task.every > 0)) throw Error(fmt::format("{} s between outputs; expected a positive number", task.every));
  ErrorSourcesReading reading = read_error_sources(specification, task.mission);
  MissionBudget out;
  out.warnings = std::move(reading.warnings);
  out.motion = nominal_motion(errors_at(task.mission, [&] { return trajectory_of(file.mission); }), 1 / file.mission.rate);
  StrapdownOptions strapdown;
  strapdown.vertical = specification.vertical;
  out.budget = error_budget(out.motion, reading.sources, {.strapdown = strapdown, .output_interval = task.every});
  std::optional<Checkpoint> checkpoint = task.checkpoint;
  if (checkpoint) checkpoint->identity = identity_of(file, specification, task);
  if (task.runs > 0) {
    out.monte_carlo = error_monte_carlo(
        out.motion, reading.sources, {.strapdown = strapdown, .output_interval = task.every, .runs = task.runs, .seed = task.seed},
        [&](std::uint64_t done) {
          if (task.progress) task.progress(static_cast<double>(done) / static_cast<double>(task.runs));
        },
        checkpoint ? &*checkpoint : nullptr);
    out.runs = task.runs;
  }
  if (auto warning = large_angles(out.budget)) out.warnings.push_back(std::move(*warning));
  return out;
}

std::string budget_json(const MissionBudget& b) { return budget_json(b.budget, b.monte_carlo, b.motion.states); }

std::string budget_page(const MissionBudget& b, const std::string& mission) {
  return budget_page(
      BudgetReport{.mission = mission,
                   .summary = {.budget = b.budget, .monte_carlo = b.monte_carlo, .runs = b.runs, .track = report::thinned_track(b.motion.states)}});
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
