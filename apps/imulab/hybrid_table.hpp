// What the hybrid method will reach, as predict and plan print it.
#pragma once

#include "imulab/analysis/hybrid_advice.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::command {

/// A line a coefficient: its sigma in user units, and beside it what is required, if anything is.
void print_hybrid_table(const HybridPrediction& prediction, const std::vector<Requirement>& requirements);

/// "gyro.matrix.xx has 31.2 ppm where 10 ppm are required" or "gyro.matrix.xx is not determined".
std::string text_of_hybrid(const Shortfall& shortfall);

/// imulab predict --method hybrid
void predict_hybrid(const std::string& procedure, const std::optional<std::string>& require, bool json);

}  // namespace imulab::command
