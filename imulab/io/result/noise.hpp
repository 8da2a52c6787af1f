// The noise of an IMU, for people and for programs.
#pragma once

#include "imulab/estimate/noise/noise_analysis.hpp"

#include <string>

namespace imulab {

/// A table of coefficients in customary units, with 95 % intervals; what is not determined has its bound alone.
std::string noise_text(const NoiseAnalysis& analysis);
/// JSON (docs/noise.md): SI, or counts; null for what is not determined.
std::string noise_json(const NoiseAnalysis& analysis);

const char* to_string(DeviationKind kind);  ///< "overlapping-allan"

}  // namespace imulab
