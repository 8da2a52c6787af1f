// The page of a noise analysis.
#pragma once

#include "imulab/model/conclusion.hpp"
#include "imulab/noise.hpp"
#include "imulab/recording/recording_view.hpp"

#include <string>

namespace imulab {

/// A self-contained HTML page: N, B and K as cards; deviations with the slopes of these terms, spectra, coefficients, and the signal with what was
/// cut.
std::string noise_page(const NoiseAnalysis& analysis, const RecordingView& recording, const Range& still, const Conclusion& conclusion = {});
/// From noise.json alone: without what needs the readings, which it names.
std::string noise_page(const NoiseAnalysis& analysis, const Conclusion& conclusion = {});
/// Several logs: mean, spread and worst of each coefficient, and the deviations of all.
std::string noise_page(const NoiseBatch& batch, const Conclusion& conclusion = {});

}  // namespace imulab
