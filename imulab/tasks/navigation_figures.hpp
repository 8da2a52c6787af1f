// The figures of error budgets and navigations on which a requirement may be, and their units.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/core/stated_limit.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/results/navigation.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

inline constexpr const char* figure_form = "FIGURE <= NUMBER UNIT, or FIGURE <= NUMBER UNIT at SECONDS s";

/// Limits on the errors of a mission: "CEP <= 1 nmi/h", "CEP <= 200 m at 600 s". Judged by the Monte Carlo where there is one, else by the linear
/// propagation, which each result then says. With aids times count from their loss, and each result says for how long it is met. Throws Error for a
/// figure, a unit or a time that the budget does not have.
std::vector<RequirementResult> assess(const ErrorBudget& budget, const std::optional<ErrorDistribution>& monte_carlo, std::string_view limits);

/// Limits on the errors of navigations: "horizontal <= 100 m at 300 s" of each, "CEP <= 1 nmi/h" of all. Throws Error also where one has no truth.
std::vector<RequirementResult> assess(const std::vector<NavigatedSession>& sessions, std::string_view limits);

/// Throws Error where the text names a figure or a unit that there is not: before the work.
void expect_budget_limits(std::string_view limits);
void expect_navigation_limits(std::string_view limits);

/// The lengths that requirements limit, over the time since the aids' loss; without a requirement the horizontal RMS. Empty without a loss.
std::vector<LossCurve> loss_curves(const ErrorBudget& budget, const std::vector<RequirementResult>& requirements);

/// The radius about zero that holds this part of a horizontal error with this mean and covariance.
double radius_of(double part, const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance);

}  // namespace imulab
