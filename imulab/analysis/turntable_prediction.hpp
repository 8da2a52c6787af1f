// How good a turntable calibration will be, before any table time is spent: in closed form with the share of every error source, and by Monte Carlo
// without linearising (docs/predict.md).
#pragma once

#include "imulab/estimate/turntable_estimator.hpp"
#include "imulab/model/noise.hpp"
#include "imulab/recording/session.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace imulab {

/// A procedure, the table that does it and the unit on it. The unit is an ideal one with SI readings and this noise.
struct TurntablePlan {
  TableObservations observations;  ///< of the steps; no readings
  RigDeclaration rig;
  Site site;
  NoiseModel accel_noise, gyro_noise;  ///< N and turn_on count
  std::vector<int> terms;              ///< what the calibration estimates, table indices
  /// Zhang's formulas on his procedure: weights from the sensors' noise alone, the gyros' bias in turns apart, and the rests of turns only in their sums.
  bool classical = false;
};

/// Of the procedure's only recording. Offsets and matrices, and g-sensitivity where the grade has it. Throws Error where the procedure is not one of
/// a turntable, its steps are wrong, or the unit's noise is not declared.
TurntablePlan turntable_plan(const Session& procedure);

/// The source that stands for what the procedure does not determine: left at its start, it may be off by its prior.
inline constexpr const char* undetermined_source = "undetermined coefficients";

/// Standard uncertainties to come, one row for each of `coefficients`.
struct TurntablePrediction {
  std::vector<int> coefficients, undetermined;  ///< table indices
  std::vector<std::string> sources;             ///< "orthogonality", "angle", "zero", "timing", "gravity", ...: columns of `variance`
  Eigen::MatrixXd variance;                     ///< to first order, by source
  Eigen::VectorXd second_order;                 ///< sigma of the second-order part
  Eigen::VectorXd bias;                         ///< mean of the second-order part, which `calibrate` takes out
  Eigen::VectorXd cramer_rao;                   ///< the least sigma that an unbiased estimate from these readings can have, to first order
  Eigen::VectorXd first_order() const { return variance.rowwise().sum().cwiseSqrt(); }
  Eigen::VectorXd sigma() const { return (variance.rowwise().sum() + second_order.cwiseAbs2()).cwiseSqrt(); }
};

TurntablePrediction predict(const TurntablePlan& plan);

struct MonteCarloResult {
  std::vector<int> coefficients;
  std::uint64_t runs = 0;
  Eigen::VectorXd mean;            ///< of the errors
  Eigen::VectorXd sigma;           ///< root mean square error
  Eigen::VectorXd sampling_sigma;  ///< standard deviation of `sigma`, relative
};

/// Whole procedures with drawn table errors, g and noise, each calibrated, at the level of rest means and turn sums. Bit-equal on any number of
/// threads. `progress` is called with the number of finished runs, from any thread.
MonteCarloResult monte_carlo(const TurntablePlan& plan, std::uint64_t runs, std::uint64_t seed,
                             const std::function<void(std::uint64_t)>& progress = {});

}  // namespace imulab
