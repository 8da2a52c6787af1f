// Where the hybrid method starts: the coarse solution from the rests (Cheng 2014 sec 1.2), and the axes as the motion shows them.
#pragma once

#include "imulab/estimate/common.hpp"

namespace imulab {

/// Rests, their noise, and a coarse solution of both triads. Throws as start_from_rests does, and Error for axes that are swapped, reversed or
/// left-handed.
Start hybrid_start(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double latitude, double gravity);

}  // namespace imulab
