// The noise of a part at rest of a recording in memory or on disk.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/noise/noise_fit.hpp"
#include "imulab/noise/still_part.hpp"
#include "imulab/recording/recording_view.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// Analyzes axes in parallel; the result does not depend on the number of threads. Columns on disk are analyzed one at a time, each completely in
/// memory but only once, with bit-identical results. Throws Unsupported if a temperature to be removed is missing or constant.
NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options = {});

}  // namespace imulab
