// Comparisons of calibrations as JSON and as a table.
#pragma once

#include "imulab/model/compare.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NamedCalibration {
  std::string name;  ///< of its file
  Calibration calibration;
};

/// `calibrations`: the first is a, each of the others b of one comparison. One comparison as an object {"a", "b", "frame", "coefficients",
/// "consistency"}; several as {"comparisons": [such objects], "agreement": {...} or null}. SI, and user units beside.
std::string comparison_json(const std::vector<NamedCalibration>& calibrations, const std::vector<Comparison>& comparisons,
                            const std::optional<Agreement>& agreement);

/// The results of the tests, then one row per coefficient: for one comparison the difference in user units and in sigmas, of several each difference
/// in sigmas. With `values`, also the values in SI.
std::string comparison_table(const std::vector<NamedCalibration>& calibrations, const std::vector<Comparison>& comparisons,
                             const std::optional<Agreement>& agreement, bool values = false);

}  // namespace imulab
