// Static calibration without a rig (docs/static.md): Cheng's coarse solution from the rests alone, then its maximum-likelihood refinement.
#pragma once

#include "imulab/estimate/handheld.hpp"

namespace imulab {

/// Accelerometers from |f| = g. Gyros, where they resolve Earth's rate at a known latitude, from the angle between Earth's rate and gravity and from its
/// size. Throws Unsupported where nothing can be determined, Error where the declared units contradict the data.
Calibration calibrate_static(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, const Site& site,
                             const EstimateOptions& options = {});

}  // namespace imulab
