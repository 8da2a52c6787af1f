// Do stations, or operators, differ? Gauge repeatability and reproducibility with units that are measured once or several times, here or there.
#pragma once

#include "imulab/core/eigen.hpp"

#include <vector>

namespace imulab {

/// Calibrations of one coefficient: y = level + unit + error. Of unit `unit[k]` at the level `level[k]` (a station, an operator), both from 0.
struct GaugeInput {
  std::vector<Eigen::Index> unit, level;
  Eigen::Index levels = 0;
  Eigen::ArrayXd values, variances;
};

struct GaugeLevel {
  Eigen::Index calibrations = 0;
  double bias = 0, low = 0, high = 0;  ///< from the mean of all levels, with its interval
};

struct Gauge {
  std::vector<GaugeLevel> levels;  ///< those without calibrations have none, and no bias
  double repeatability = 0;        ///< standard deviation of one unit at one level, beyond the uncertainties; 0 where no unit was measured twice
  double reproducibility = 0;      ///< standard deviation between levels, apart from the uncertainty of their biases
  double spread = 0;               ///< between units
  double p_value = 1;              ///< of such biases where there are none
  bool units_shared = false;  ///< whether units were measured at several levels; else only the number of units separates a bias from their spread
};

/// Generalized least squares with units as random effects; their spread and the repeatability are estimated together with the biases. Fewer than two
/// levels: no bias.
Gauge compare_levels(const GaugeInput& input, double confidence = 0.95);

}  // namespace imulab
