// The resolution of readings.
#pragma once

#include "imulab/noise.hpp"

#include <optional>
#include <span>
#include <vector>

namespace imulab {

/// The step of rounded readings, where enough of its multiples occur; 0 where none is seen.
double resolution_of(std::span<const double> rate);

}  // namespace imulab
