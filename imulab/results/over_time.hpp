// Results over time in JSON: navigation, error budgets and compensated recordings read back, and the quantities of a budget as files name them.
#pragma once

#include "imulab/formats/text/json.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/units.hpp"

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::result_io {

/// Position, velocity and attitude error east, north and up; horizontal position error.
inline constexpr std::array<std::string_view, budget_quantities + 1> quantity_names{"pe", "pn", "pu", "ve", "vn", "vu", "ae", "an", "au", "ph"};

/// m, m/s, arcsec.
inline double quantity_size(Eigen::Index quantity) { return quantity >= 6 && quantity < budget_quantities ? unit::arcsec : 1; }

/// One sigma of each quantity over time, SI.
inline BudgetRows total_sigma(const ErrorBudget& b) {
  BudgetRows sigma(budget_quantities, static_cast<Eigen::Index>(b.time.size()));
  for (std::size_t i = 0; i < b.time.size(); ++i) sigma.col(static_cast<Eigen::Index>(i)) = b.covariance[i].diagonal().cwiseMax(0.0).cwiseSqrt();
  return sigma;
}

/// Shares of each group, then of the correlation between groups, in the mean square of each quantity at the end.
using NamedNumbers = std::vector<std::pair<std::string, double>>;
std::vector<std::pair<std::string, NamedNumbers>> shares_at_end(const ErrorBudget& b);

NavigationSummary navigation_of(const json_io::Field& root);
BudgetSummary budget_of(const json_io::Field& root);
CompensationSummary compensation_of(const json_io::Field& root);

}  // namespace imulab::result_io
