// Navigation and error budgets as pages.
#pragma once

#include "imulab/results/summary.hpp"

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

struct BudgetReport {
  std::string mission;  ///< its name
  BudgetSummary summary;
  std::vector<std::string> missing = {};   ///< pictures that could not be drawn, and why
  std::vector<std::string> warnings = {};  ///< those that the terminal shows
  Conclusion conclusion = {};
};

/// HTML, self-contained.
std::string budget_page(const BudgetReport& report);

namespace report {
/// The error from each source at the end, the largest share first; then the coefficients one by one.
std::string sources_section(const ErrorBudget& budget);
}  // namespace report

}  // namespace imulab
