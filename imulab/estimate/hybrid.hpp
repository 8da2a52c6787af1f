// Hybrid calibration (docs/hybrid.md): a coarse static solution, then a Kalman filter on the velocity of a unit that stays in its place (Cheng 2014).
// A table only turns the unit; its angles are not used.
#pragma once

#include "imulab/estimate/handheld.hpp"
#include "imulab/estimate/hybrid_filter.hpp"

#include <string>
#include <vector>

namespace imulab {

struct HybridOptions : EstimateOptions {
  double curve_interval = 0;  ///< s between points of the convergence curves; 0: none
};

/// A coefficient as Cheng's table 1 has it: value of the coarse solution, correction, final value and its standard uncertainty.
struct HybridRow {
  int coefficient;  ///< table index
  double coarse, correction, value, sigma;
};

/// Estimated residual of the coarse solution over time, in calibrated units (ba, Ma, bg, Mg of the filter), and its standard uncertainty.
struct ConvergenceCurve {
  std::string name;  ///< of the coefficient it corrects
  std::vector<double> residual, sigma;
};

struct HybridResult {
  Calibration calibration;
  std::vector<HybridRow> table;
  std::vector<double> curve_time;  ///< s
  std::vector<ConvergenceCurve> curves;
  int repetitions = 0;
};

/// `rests` are sample ranges in time order. On a declared turntable the velocity is zero while it turns, too; else only at rest. Throws Unsupported
/// where nothing can be determined, Error where the declared units, signs or axes contradict the data.
HybridResult calibrate_hybrid(const Recording& recording, const std::vector<Range>& rests, const Session& session, const HybridOptions& options = {});

}  // namespace imulab
