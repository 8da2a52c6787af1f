// Navigation and error budgets as pages.
#pragma once

#include "imulab/results/summary.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NavigationReport {
  NavigationSummary sessions;
  std::vector<std::string> missing = {};   ///< pictures that could not be drawn, and why
  std::vector<std::string> warnings = {};  ///< besides those of the sessions
  Conclusion conclusion = {};
};

/// HTML, self-contained.
std::string navigation_page(const NavigationReport& report);

/// A figure of a budget with aids, over the time since they were lost.
struct LossCurve {
  std::string name;  ///< "CEP <= 100 m"
  std::vector<double> seconds, meters;
  std::optional<double> limit, within;  ///< m; s for which the figure is within the limit: absent with a limit: all of the time
};

struct BudgetReport {
  std::string mission;  ///< its name
  BudgetSummary summary;
  std::vector<std::string> missing = {};   ///< pictures that could not be drawn, and why
  std::vector<std::string> warnings = {};  ///< those that the terminal shows
  Conclusion conclusion = {};
  std::vector<LossCurve> curves = {};  ///< of a budget with aids
};

/// HTML, self-contained.
std::string budget_page(const BudgetReport& report);

namespace report {
/// The error from each source at the end, the largest share first; then the coefficients one by one.
std::string sources_section(const ErrorBudget& budget);
}  // namespace report

}  // namespace imulab
