// A comparison of calibrations as a page.
#pragma once

#include "imulab/results/summary.hpp"

#include <string>

namespace imulab {

/// HTML, self-contained: each difference in its sigmas, and whether all agree with the stated uncertainties.
std::string comparison_page(const ComparisonSummary& summary);

}  // namespace imulab
