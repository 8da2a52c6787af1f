// The uncertainty of a coefficient as requirements state it.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// What is wrong with a requirement that was made in memory: no coefficients, some that are not in the table or cannot be required, a limit that is
/// not finite and above 0.
std::vector<std::string> problems_of(const Requirement& requirement);

/// Standard uncertainty of a coefficient, SI; of matrices relative to the row's scale; infinite where it was not estimated.
double relative_uncertainty(const Calibration& calibration, CoefficientIndex index);

}  // namespace imulab
