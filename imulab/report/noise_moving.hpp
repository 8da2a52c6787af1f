// The section of a noise page on motion: the table of causes as bars.
#pragma once

#include "imulab/noise.hpp"

#include <string>

namespace imulab::report {

/// Empty if the analysis has no causes of motion.
std::string moving_section(const NoiseAnalysis& analysis);

}  // namespace imulab::report
