// The error budget of a mission, with its Monte Carlo.
#pragma once

#include "imulab/formats/session/mission.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/results/budget.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct BudgetTask {
  std::string mission;                                                   ///< its file: for messages, and beside it the files that it names
  std::optional<std::string> grade = {}, system = {}, calibration = {};  ///< one at most, in place of the mission's sensors; the last a file
  std::optional<std::string> noise = {};                                 ///< file of an analysis, in place of the noise terms
  std::uint64_t runs = 200, seed = 1;                                    ///< of the Monte Carlo; 0: none
  double every = 10;                                                     ///< s between outputs
  std::function<void(double)> progress = {};                             ///< called with the fraction done, 0 to 1, from any thread
  std::optional<Checkpoint> checkpoint = {};                             ///< of the Monte Carlo
};

struct MissionBudget {
  ErrorBudget budget;
  std::optional<ErrorDistribution> monte_carlo;
  std::uint64_t runs = 0;
  motion::NominalMotion motion;
  std::vector<std::string> warnings;
};

/// The mission's errors, with the task's own in their place. Throws Error where there are none.
ErrorSpecification specification_of(const BudgetTask& task, const MissionFile& file);

/// Throws Error as read_error_sources, trajectory_of, error_budget and error_monte_carlo do.
MissionBudget mission_budget(const MissionFile& file, const ErrorSpecification& specification, const BudgetTask& task);
std::string budget_json(const MissionBudget& budget);
/// HTML.
std::string budget_page(const MissionBudget& budget, const std::string& mission);
/// total.csv, sources.csv, and of a Monte Carlo monte_carlo.csv and runs.csv, in a new folder. Throws Error where it cannot be written.
void write_budget(const std::filesystem::path& folder, const MissionBudget& budget);

}  // namespace imulab
