// An error budget: CSV over time, JSON and a table at its end.
#pragma once

#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// t, then for each of the nine quantities the fixed error and one sigma: pe_fixed,pe_sigma,... (p, v, a: position m, velocity m/s, attitude arcsec;
/// e, n, u).
std::string total_csv(const ErrorBudget& budget);
/// A row a source and time, with the source's share of each mean square: source,t,pe_fixed,pe_sigma,pe_share,... The shares of a time add up to one
/// with the source "correlation between groups".
std::string sources_csv(const ErrorBudget& budget);
/// t, then for each quantity and for the horizontal position error (ph) its 5 %, median and 95 %: pe_low,pe_median,pe_high,...
std::string distribution_csv(const ErrorDistribution& distribution);
/// A row a run has the error at the end and the largest size at any output: run,pe_end,pe_peak,...
std::string runs_csv(const ErrorDistribution& distribution);
/// The end: {"time_s", "vertical", "total", "sources", "coefficients", "shares", "monte_carlo"}, then for pictures "history" and "track" at some
/// times; units are in the keys (docs/reference/navigate.md).
std::string budget_json(const ErrorBudget& budget, const std::optional<ErrorDistribution>& monte_carlo,
                        const std::vector<NavigationState>& track = {}, const std::string& grade = {}, const std::string& noise = {});
/// The end: the horizontal position error and its main causes, then a row a source, the largest share first. With `details` also velocity, attitude
/// and the Monte Carlo.
std::string budget_table(const ErrorBudget& budget, const std::optional<ErrorDistribution>& monte_carlo, bool details = false);

/// Root of the mean square horizontal position error, fixed and drawn together [m]: at an output, of one source, and of a Monte Carlo's runs at the
/// end.
double horizontal_rms(const ErrorBudget& budget, std::size_t at);
double horizontal_rms(const Contribution& source, Eigen::Index at);
double horizontal_rms(const ErrorDistribution& runs);
/// "after 5400 s: horizontal position error 1360 m RMS, height fixed"
/// Where the linear figures are rough, that of the Monte Carlo.
std::string budget_headline(const ErrorBudget& budget, const std::optional<ErrorDistribution>& monte_carlo = std::nullopt);
/// Why the linear figures are rough, where they are: above a tenth of a radian, products of errors are some percent of the errors.
std::optional<std::string> large_angles(const ErrorBudget& budget);

/// Published grades and airliners' systems (Xu 2024), and the grades that a unit can be drawn from.
std::string grade_catalogue();

}  // namespace imulab
