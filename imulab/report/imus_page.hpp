// The page of several IMUs of one log, each calibrated on its own.
#pragma once

#include "imulab/results/comparison.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Verdicts, and the coefficients beside each other with their expanded uncertainties. `missing`: those that could not be calibrated.
std::string imus_page(const std::string& log, const std::vector<NamedCalibration>& imus, const std::vector<std::string>& missing);

}  // namespace imulab
