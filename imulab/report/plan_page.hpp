// A planned procedure as a page.
#pragma once

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/io/result/summary.hpp"

#include <string>
#include <vector>

namespace imulab {

struct PlanReport {
  std::vector<Requirement> requirements;
  hybrid::Path path;
  PredictionSummary summary;
};

/// HTML, self-contained.
std::string plan_page(const PlanReport& report);

}  // namespace imulab
