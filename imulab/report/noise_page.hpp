// The page of a noise analysis.
#pragma once

#include "imulab/noise/noise_analysis.hpp"

#include <string>

namespace imulab {

/// A self-contained HTML page: deviation with bounds and fitted terms, spectrum, coefficients, and the signal with what was cut.
std::string noise_page(const NoiseAnalysis& analysis, const RecordingView& recording, const Range& still);

}  // namespace imulab
