// Several logs together, of one unit or of a batch: mean, spread and worst of each coefficient.
#pragma once

#include "imulab/noise/noise_analysis.hpp"

#include <array>
#include <vector>

namespace imulab {

struct BatchCoefficient {
  int determined = 0;  ///< number of logs that determine it
  /// Mean of these, with the larger of the uncertainty that the logs state and that their scatter shows; where none determines it, the largest bound.
  NoiseCoefficient mean;
  double spread = 0;  ///< standard deviation from log to log beyond what the logs' uncertainties explain; NaN for fewer than two
  double worst = 0;   ///< largest value, or bound of a log that does not determine it
  std::size_t worst_log = 0;
};

/// Q, N, B, K, R of one axis, in this order.
struct BatchAxis {
  std::string name, unit;
  std::array<BatchCoefficient, 5> coefficients;
};

struct NoiseBatch {
  std::vector<NoiseAnalysis> logs;
  std::vector<BatchAxis> axes;
};

/// Throws Error where the logs' units differ.
NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs);

}  // namespace imulab
