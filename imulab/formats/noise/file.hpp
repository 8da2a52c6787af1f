// noise.json: what `imulab noise` writes (docs/noise.md), and its coefficients read back. Its fields stand in noise/noise_fields.hpp.
#pragma once

#include "imulab/noise/noise_analysis.hpp"

#include <string>
#include <string_view>

namespace imulab {

/// SI, or counts; null for what is not determined. Of several logs: mean, spread, and the worst; then each log's own.
std::string noise_json(const NoiseAnalysis& analysis);
std::string noise_json(const NoiseBatch& batch);

/// Throws Error that names file and field where it is no "imulab.noise/1".
ImuNoise read_noise(const std::string& path);
/// From text; `file` is its name in messages.
ImuNoise parse_noise(std::string_view text, const std::string& file);

}  // namespace imulab
