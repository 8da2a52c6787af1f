// The error budget of a mission, with its Monte Carlo.
#pragma once

#include "imulab/formats/session/mission.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct BudgetVerbOptions : ShowOptions {
  std::string mission;                                           ///< its file: for messages, and beside it the files that it names
  std::optional<std::string> require;                            ///< limits on figures (tasks/navigation_figures.hpp)
  std::optional<std::string> grade, system, calibration, noise;  ///< in place of the mission's: sensors by one of the first three, noise
  std::uint64_t runs = 200, seed = 1;                            ///< of the Monte Carlo; 0 runs: none
  double every = 10;                                             ///< s between outputs
  bool catalogue = false, allow_undetermined = false;
  SharingOptions shared;
};
/// The verb `budget`, which sets these.
Verb& declare(Verb& command, BudgetVerbOptions& o);

struct MissionBudget {
  ErrorBudget budget;
  std::optional<ErrorDistribution> monte_carlo;
  std::uint64_t runs = 0;
  motion::NominalMotion motion;
  std::vector<std::string> warnings;
  bool doubtful = false;     ///< for a reason among the warnings
  std::string grade, noise;  ///< of the sensors: a grade's or a system's name, and where the noise comes from
};

/// The mission's budget with the options' own sensors in place of the mission's. `tell` gets the warnings about the calibration that these name at
/// once; the answer has them as told. `progress` is called with the fraction done, 0 to 1, from any thread. Throws Error where there are no errors of
/// sensors, and as read_error_sources, trajectory_of, error_budget and error_monte_carlo do; as expect_usable for the calibration.
AnswerOf<MissionBudget> budget_answer(const MissionFile& file, const BudgetVerbOptions& o, const Tell& tell,
                                      const std::function<void(double)>& progress, const std::string& allow = "--allow-undetermined");
/// The names of `--grade` where it lists several; else empty.
std::vector<std::string> several_grades(const BudgetVerbOptions& o);
/// The budgets of several grades on one mission, each as budget_answer has it, side by side. Throws Error where files for one were asked for.
Answer grades_answer(const MissionFile& file, const BudgetVerbOptions& o, const Tell& tell, const std::function<void(double)>& progress);
/// total.csv, sources.csv, and of a Monte Carlo monte_carlo.csv and runs.csv, in a new folder. Throws Error where it cannot be written.
void write_budget(const std::filesystem::path& folder, const MissionBudget& budget);

}  // namespace imulab
