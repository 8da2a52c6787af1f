// The uncertainty of a coefficient as requirements state it.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Standard uncertainty of a coefficient, SI; of matrices relative to the row's scale; infinite where it was not estimated.
double relative_uncertainty(const Calibration& calibration, CoefficientIndex index);

}  // namespace imulab
