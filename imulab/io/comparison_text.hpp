// Comparisons of calibrations as JSON, for machines.
#pragma once

#include "imulab/analysis/compare.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// `files` are the calibrations' names: the first is a, the others one a comparison. One comparison as an object {"a", "b", "coefficients",
/// "consistency"}; several as {"comparisons": [such objects], "agreement": {...} or null}.
std::string comparison_json(const std::vector<std::string>& files, const std::vector<Comparison>& comparisons,
                            const std::optional<Agreement>& agreement);

}  // namespace imulab
