// Hybrid calibration (docs/hybrid.md): a coarse static solution, then a Kalman filter on the velocity of a unit that stays in its place (Cheng 2014).
// A table only turns the unit; its angles are not used.
#pragma once

#include "imulab/estimate/handheld.hpp"

#include <string>
#include <vector>

namespace imulab {

struct HybridOptions : EstimateOptions {
  double curve_interval = 0;  ///< s between points of the convergence curves; 0: none
};

/// Residual of the coarse solution as the last pass sees it over time, in calibrated units (ba, Ma, bg, Mg of the filter), and its standard
/// uncertainty.
struct ConvergenceCurve {
  std::string name;  ///< of the coefficient it corrects
  std::vector<double> residual, sigma;
};

struct HybridResult {
  Calibration calibration;
  SensorModel coarse;              ///< with the calibration: Cheng's table 1
  std::vector<double> curve_time;  ///< s of the recording's clock
  std::vector<ConvergenceCurve> curves;
  int repetitions = 0;
};

/// `rests` are sample ranges in time order. On a declared turntable the velocity is zero while it turns, too; else only at rest. Throws Unsupported
/// where nothing can be determined, Error where the declared units, signs or axes contradict the data.
HybridResult calibrate_hybrid(const Recording& recording, const std::vector<Range>& rests, const Session& session, const HybridOptions& options = {});

}  // namespace imulab
