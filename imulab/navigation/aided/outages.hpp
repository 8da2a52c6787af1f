// What was withheld, against what was predicted there.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"

#include <vector>

namespace imulab::aided {

/// Compares the withheld positions with the smoothed trajectory, or with the filter's, as this part of the results.
void add_outages(const Problem& problem, const std::vector<Withheld>& withheld, OutageErrors OutageResult::*part, std::vector<OutageResult>& outages);

}  // namespace imulab::aided
