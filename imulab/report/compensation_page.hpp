// Compensated recordings as a page.
#pragma once

#include "imulab/results/compensation.hpp"

#include <string>
#include <vector>

namespace imulab {

/// HTML, self-contained. `missing`: pictures that cannot be drawn, and why.
std::string compensation_page(const CompensationSummary& summary, const std::vector<std::string>& missing = {});

}  // namespace imulab
