// Compensated recordings as CSV.
#pragma once

#include "imulab/analysis/compensate_recording.hpp"

#include <string>

namespace imulab {

/// t,gx,gy,gz,ax,ay,az in SI, increments where the recording has increments; a `flags` column where some sample is flagged, with
/// saturated, out_of_range (temperature) and replaced (an outlier) joined by "|". Numbers read back exactly.
std::string compensated_text(const CompensatedRecording& compensated);

/// The parts of that text, for recordings that come in pieces.
std::string compensated_header(bool flags);
std::string compensated_rows(const CompensatedRecording& compensated, bool flags);

}  // namespace imulab
