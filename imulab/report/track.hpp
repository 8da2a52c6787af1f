// Tracks on the Earth and errors over time, for the pages of navigation.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"

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

/// A length as a reader takes it: m, from 10 km on km.
struct LengthUnit {
  std::string_view name;
  double size;  ///< m
};
LengthUnit length_unit(double largest);
std::string length_text(double length);

/// Errors over time with their expected sizes. `errors`: nine rows, at `error_time`; may be empty.
struct ErrorBands {
  const ErrorBudget* budget = nullptr;
  const ErrorDistribution* monte_carlo = nullptr;
  std::vector<double> error_time;  ///< s
  BudgetRows errors;
  double start = 0;    ///< s: from which the pictures count
  bool rough = false;  ///< the budget is: pictures are as large as the Monte Carlo needs
};
/// The horizontal position error: one large picture.
std::string horizontal_picture(const ErrorBands& bands);
/// All nine: small pictures. East and north have one scale.
std::string error_bands(const ErrorBands& bands);

/// Shares of the mean square horizontal position error: a row an output time, a column each source and last the correlation between groups.
Eigen::MatrixXd horizontal_shares(const ErrorBudget& budget);
/// The largest shares over time, from `start` [s] on.
std::string shares_over_time(const ErrorBudget& budget, double start = 0);

}  // namespace imulab::report
