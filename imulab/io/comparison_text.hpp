// Comparisons of calibrations as JSON, for machines.
#pragma once

#include "imulab/analysis/compare.hpp"

#include <string>
#include <vector>

namespace imulab {

/// A comparison and the files it is of.
struct NamedComparison {
  std::string a, b;
  Comparison comparison;
};

/// One comparison as an object {"a", "b", "coefficients", "consistency"}; several as {"comparisons": [...]} of such.
std::string comparison_json(const std::vector<NamedComparison>& comparisons);

}  // namespace imulab
