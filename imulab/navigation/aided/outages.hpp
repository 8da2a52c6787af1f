// Comparison of withheld values with their prediction.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"

#include <vector>

namespace imulab::aided {

/// Compares the withheld positions with the smoothed trajectory or the filter's, and stores the errors in this part of the results.
void add_outages(const Problem& problem, const std::vector<Withheld>& withheld, OutageErrors OutageResult::*part, std::vector<OutageResult>& outages);

}  // namespace imulab::aided
