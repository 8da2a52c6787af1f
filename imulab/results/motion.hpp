// The rates and forces of a motion, as a table.
#pragma once

#include "imulab/navigation/integration/strapdown.hpp"
#include "imulab/recording/recording.hpp"

#include <string>

namespace imulab {

/// Distance, speed and bank of the motion; largest rate and force of its recording where that is in SI.
std::string motion_table(const Recording& recording, const Solution& truth);

}  // namespace imulab
