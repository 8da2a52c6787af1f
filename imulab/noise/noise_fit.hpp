// The resolution of readings.
#pragma once

#include "imulab/noise.hpp"

#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// Returns the step of rounded readings if enough of its multiples occur, or 0 if no step is found.
double resolution_of(std::span<const double> rate);

}  // namespace imulab
