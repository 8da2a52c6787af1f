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

/// Axes in parallel; the result does not depend on the number of threads. From columns on disk: one axis at a time, each in memory as a whole but
/// only once; the result is the same, bit for bit. Throws Unsupported where a temperature is to be removed that the recording does not have, or that
/// does not change.
NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options = {});

}  // namespace imulab
