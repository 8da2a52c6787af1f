// Tracks on the Earth and errors over time, for the pages of navigation.
#pragma once

#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/integration/strapdown.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::report {

/// At most about `points` of them, the first and the last included.
std::vector<NavigationState> thinned_track(const std::vector<NavigationState>& states, std::size_t points = 800);

/// East and north of the start, both on one scale.
std::string track_figure(const std::vector<NavigationState>& track, std::string_view caption);

/// Names and customary units of the nine quantities of an error: position m, velocity m/s, attitude arcsec; east, north, up.
struct ErrorQuantity {
  std::string_view name, unit;
  double size;
};
const std::array<ErrorQuantity, budget_quantities>& error_quantities();

/// Errors over time with their expected sizes: nine small charts. `errors`: nine rows, at `error_time`; may be empty.
struct ErrorBands {
  const ErrorBudget* budget = nullptr;
  const ErrorDistribution* monte_carlo = nullptr;
  std::vector<double> error_time;  ///< s
  BudgetRows errors;
  double start = 0;  ///< s: from which the pictures count
};
std::string error_bands(const ErrorBands& bands);

/// Shares of the mean square horizontal position error: a row an output time, a column each source and last the correlation between groups.
Eigen::MatrixXd horizontal_shares(const ErrorBudget& budget);
/// The largest shares over time, from `start` [s] on.
std::string shares_over_time(const ErrorBudget& budget, double start = 0);

}  // namespace imulab::report
