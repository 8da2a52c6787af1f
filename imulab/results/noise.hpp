// The noise of an IMU, for people and for programs.
#pragma once

#include "imulab/noise/noise_analysis.hpp"

#include <string>

namespace imulab {

/// A table of coefficients in customary units, with 95 % intervals; a coefficient that is not determined has only its bound.
std::string noise_text(const NoiseAnalysis& analysis);
/// JSON (docs/noise.md): SI, or counts; null for what is not determined.
std::string noise_json(const NoiseAnalysis& analysis);

/// Of several logs: mean, spread, and the worst; then each log's own, as above.
std::string noise_text(const NoiseBatch& batch);
std::string noise_json(const NoiseBatch& batch);

}  // namespace imulab
