// Compensated recordings as CSV.
#pragma once

#include "imulab/analysis/compensate_recording.hpp"

#include <string>

namespace imulab {

/// t,gx,gy,gz,ax,ay,az in SI, increments where the recording has increments; a `flags` column where some sample is flagged, with
/// saturated, out_of_range (temperature), or both joined by "|". Numbers read back exactly.
std::string compensated_text(const CompensatedRecording& compensated);

}  // namespace imulab
