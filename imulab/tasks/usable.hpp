// Calibrations that may be applied.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Throws Error, with `name` in front, where a coefficient is beyond any size with which one can compute.
void expect_sizes(const Calibration& calibration, const std::string& name);

struct Usability {
  std::vector<std::string> warnings;  ///< what is taken as declared
  std::string undetermined;           ///< offsets or matrices that keep starting values, which compensate nothing; empty: all are determined
};
/// Texts have `name` in front. Throws as expect_sizes.
Usability usability(const Calibration& calibration, const std::string& name);

}  // namespace imulab
