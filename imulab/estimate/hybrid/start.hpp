// The start of the hybrid method: the coarse solution from the rests (Cheng 2014 sec 1.2), and a check of the axes by the motion.
#pragma once

#include "imulab/estimate/kernel/rest_start.hpp"

namespace imulab::hybrid {

/// Rests, their noise, and a coarse solution of both triads. Throws as kernel::start_from_rests does, and Error for axes that are swapped, reversed
/// or left-handed.
kernel::RestStart coarse_start(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double latitude,
                               double gravity);

}  // namespace imulab::hybrid
