// Calibrations that may be compared, and their comparison.
#pragma once

#include "imulab/results/comparison.hpp"
#include "imulab/results/summary.hpp"

#include <string>
#include <vector>

namespace imulab {

struct ComparedCalibrations {
  ComparisonSummary summary;
  std::vector<std::string> warnings;  ///< frames that are not known
};

/// The others with the first; an agreement of all where there are three or more that state uncertainties. Throws Error for a singular matrix,
/// readings in different units, and serial numbers that differ unless `different_imus`.
ComparedCalibrations compare_calibrations(const std::vector<NamedCalibration>& calibrations, bool different_imus = false);

}  // namespace imulab
