// A planned procedure as a page.
#pragma once

#include "imulab/results/summary.hpp"

#include <string>

namespace imulab {

/// HTML, self-contained.
std::string plan_page(const PlanSummary& plan);

}  // namespace imulab
