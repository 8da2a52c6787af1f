// The uncertainty of a turntable calibration before it is carried out: in closed form with the contribution of every error source, and by Monte Carlo
// without linearization (docs/theory/strapdown.md).
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

/// A procedure, its table, and the unit: an ideal IMU with SI readings and this noise.
struct Plan {
  TablePlan parts;
  RigDeclaration rig;
  Site site;
  NoiseModel accel_noise, gyro_noise;   ///< only N and turn_on are used
  std::vector<CoefficientIndex> terms;  ///< coefficients that the calibration estimates
  /// Priors of optional terms. Absent: `terms` are estimated from the data alone, like terms that a user names.
  std::optional<kernel::PriorSizes> optional;
  std::optional<kernel::EffectSizes> effects;  ///< effects of the unit, estimated jointly with the terms; absent: none
  /// Zhang's formulas for his procedure: weights from sensor noise alone, a separate gyro bias in turns, rests around turns used only in their sums.
  bool classical = false;
};

/// Returns the plan of the procedure's only recording; `terms` as in CalibrationOptions. Throws Error if the procedure is not for a turntable, its
/// steps are wrong, or the unit's noise is not declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});
/// Returns the plan with Zhang's model: only offsets and matrices, with his weights.
Plan classical(Plan plan);

/// Predicts with the contribution of every error source, without Monte Carlo.
Prediction predict(const Plan& plan);
/// Predicts a procedure, with Monte Carlo and tolerances that would meet the requirements, as requested.
Prediction predict(const Session& procedure, const PredictionOptions& options);

/// Simulates and calibrates complete procedures with random table errors, g, terms with a prior, and noise, at the level of rest means and turn sums.
/// Bit-identical for any number of threads and processes. `progress` is called with the number of finished runs, from any thread.
MonteCarloResult monte_carlo(const Plan& plan, std::uint64_t runs, std::uint64_t seed, const std::function<void(std::uint64_t)>& progress = {},
                             const Sharing* sharing = nullptr);

}  // namespace imulab::turntable
