// The uncertainty of a turntable calibration before any table time is spent: in closed form with the share of every error source, and by Monte Carlo
// without linearizing (docs/theory/strapdown.md).
#pragma once

#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/grade.hpp"
#include "imulab/rig/table_plan.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace imulab::turntable {

/// A procedure, the table that performs it and the unit on it: an ideal one with SI readings and this noise.
struct Plan {
  TablePlan parts;
  RigDeclaration rig;
  Site site;
  NoiseModel accel_noise, gyro_noise;   ///< only N and turn_on are used
  std::vector<CoefficientIndex> terms;  ///< the coefficients that the calibration estimates
  /// The priors of terms that an IMU may not have. Absent: `terms` are estimated by the data alone, as those that a user names.
  std::optional<kernel::PriorSizes> optional;
  std::optional<kernel::EffectSizes> effects;  ///< the unit's, estimated beside the terms; absent: it has none
  /// Zhang's formulas on his procedure: weights from the sensors' noise alone, the gyros' bias in turns apart, and the rests of turns only in their
  /// sums.
  bool classical = false;
};

/// The plan of the procedure's only recording; `terms` as CalibrationOptions has them. Throws Error where the procedure is not one of a turntable,
/// its steps are wrong, or the unit's noise is not declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});
/// The plan with Zhang's model: offsets and matrices alone, by his weights.
Plan classical(Plan plan);

/// With the share of every error source; no Monte Carlo.
Prediction predict(const Plan& plan);
/// Predicts a procedure, with a Monte Carlo and the tolerances that would meet the requirements, as asked.
Prediction predict(const Session& procedure, const PredictionOptions& options);

/// Whole procedures with drawn table errors, g, terms with a prior, and noise, each calibrated, at the level of rest means and turn sums. Bit-equal
/// on any number of threads and processes. `progress` is called with the number of finished runs, from any thread.
MonteCarloResult monte_carlo(const Plan& plan, std::uint64_t runs, std::uint64_t seed, const std::function<void(std::uint64_t)>& progress = {},
                             const Sharing* sharing = nullptr);

}  // namespace imulab::turntable
