// The noise of an IMU, for people.
#pragma once

#include "imulab/formats/noise/file.hpp"
#include "imulab/noise/noise_analysis.hpp"

#include <string>

namespace imulab {

/// A table of coefficients in customary units, with 95 % intervals; a coefficient that is not determined has only its bound.
std::string noise_text(const NoiseAnalysis& analysis);
/// The mean of several logs, its spread, and the worst.
std::string noise_text(const NoiseBatch& batch);

}  // namespace imulab
