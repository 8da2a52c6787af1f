// Navigated sessions as a page.
#pragma once

#include "imulab/results/summary.hpp"

#include <string>
#include <vector>

namespace imulab {

struct NavigationReport {
  NavigationSummary sessions;
  std::vector<std::string> missing = {};  ///< pictures that could not be drawn, and why
};

/// HTML, self-contained.
std::string navigation_page(const NavigationReport& report);

}  // namespace imulab
