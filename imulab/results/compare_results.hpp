// Saved results of one kind side by side: budgets, noise, predictions, navigations.
#pragma once

#include "imulab/results/summary.hpp"

#include <string>
#include <vector>

namespace imulab {

struct NamedResult {
  std::string name;  ///< of its file, or a budget's grade
  SavedResult result;
  std::string note = {};  ///< what is known of it besides, as the noise of a budget
};

/// The name of a result's kind: "calibration", "budget", ...
std::string kind_name(const SavedResult& result);

/// Throws Error for fewer than two results, a mix of kinds, and a kind or content that cannot be compared.
ResultComparison compare_results(const std::vector<NamedResult>& results);
/// The budgets of several grades of sensors on one mission. Throws Error as compare_results.
ResultComparison compare_grades(std::vector<BudgetSummary> budgets);

}  // namespace imulab
