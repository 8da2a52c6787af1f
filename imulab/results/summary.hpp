// Results of verbs as values that their JSON gives back, for reports.
#pragma once

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/compare.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/results/compensation.hpp"
#include "imulab/results/navigation.hpp"
#include "imulab/results/prediction.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace imulab {

struct ComparisonSummary {
  std::vector<std::string> names;       ///< a, then the others
  std::vector<Comparison> comparisons;  ///< one for each of the others
  std::optional<Agreement> agreement = {};
};

/// SI. Rows and elements in the order of `coefficients`.
struct PredictionSummary {
  std::vector<CoefficientIndex> coefficients, undetermined;
  Eigen::VectorXd sigma, cramer_rao;  ///< the bound: NaN where it is not stated
  std::optional<Eigen::VectorXd> monte_carlo = {};
  std::uint64_t runs = 0;                 ///< of the Monte Carlo
  std::vector<std::string> sources = {};  ///< columns of `variance`; none where the method does not tell them apart
  Eigen::MatrixXd variance = {};
  std::vector<Shortfall> missed = {};    ///< requirements
  std::vector<std::string> advice = {};  ///< further turns
};

struct PlanSummary {
  std::vector<Requirement> requirements;
  hybrid::Path path;  ///< from JSON: without its worst ratio
  PredictionSummary prediction;
  std::optional<PriorEffect> prior = {};
};

struct BudgetSummary {
  /// From JSON: some of the times, with a diagonal covariance; over time of single sources the horizontal position alone.
  ErrorBudget budget;
  std::optional<ErrorDistribution> monte_carlo;
  std::uint64_t runs = 0;                   ///< of the Monte Carlo
  std::vector<NavigationState> track = {};  ///< of the motion, thinned
};

/// Of several sessions: those of one command. From JSON: begin and end in `solution.time`, track and errors thinned.
using NavigationSummary = std::vector<NavigatedSession>;

using SavedResult =
    std::variant<Calibration, ComparisonSummary, PredictionSummary, PlanSummary, NavigationSummary, BudgetSummary, CompensationSummary>;

/// Reads calibration.json or what `compare`, `predict`, `plan`, `navigate`, `budget` or `compensate` print with --json. Throws Error that names the
/// file and what was expected.
SavedResult read_result(const std::filesystem::path& path);
/// The same from text; `file` is its name in messages.
SavedResult parse_result(std::string_view text, const std::string& file);

}  // namespace imulab
