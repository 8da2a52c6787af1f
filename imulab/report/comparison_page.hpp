// Comparisons as pages: of calibrations, and of saved results of one kind.
#pragma once

#include "imulab/results/result_comparison.hpp"
#include "imulab/results/summary.hpp"

#include <string>
#include <vector>

namespace imulab {

/// HTML, self-contained: each difference in its sigmas, and whether all agree with the stated uncertainties.
std::string comparison_page(const ComparisonSummary& summary, const std::vector<std::string>& warnings = {});

/// HTML, self-contained: one figure with the curves of all results, one table.
std::string result_comparison_page(const ResultComparison& comparison, const Conclusion& conclusion = {},
                                   const std::vector<std::string>& warnings = {});

}  // namespace imulab
