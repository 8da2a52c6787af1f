// Do stations, or operators, differ? Gauge repeatability and reproducibility with units that are measured once or several times, here or there.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

#include <vector>

namespace imulab {

/// Calibrations of one coefficient: y = level + unit + error. Of unit `unit[k]` at the level `level[k]` (a station, an operator), both from 0.
struct GaugeInput {
  std::vector<Eigen::Index> unit, level;
  Eigen::Index levels = 0;
  Eigen::ArrayXd values, variances;
};

/// Generalized least squares with units as random effects; their spread and the repeatability are estimated together with the biases. Fewer than two
/// levels: no bias.
Gauge compare_levels(const GaugeInput& input, double confidence = 0.95);

}  // namespace imulab
