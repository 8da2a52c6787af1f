// How good a turntable calibration will be, before any table time is spent: in closed form with the share of every error source, and by Monte Carlo
// without linearizing (docs/predict.md).
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/imu_noise.hpp"
#include "imulab/rig/table_plan.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::turntable {

/// A procedure, the table that performs it and the unit on it: an ideal one with SI readings and this noise.
struct Plan {
  TablePlan parts;
  RigDeclaration rig;
  Site site;
  NoiseModel accel_noise, gyro_noise;   ///< only N and turn_on are used
  std::vector<CoefficientIndex> terms;  ///< the coefficients that the calibration estimates
  /// Of those that an IMU may not have. Absent: `terms` are estimated by the data alone, as those that a user names.
  std::optional<kernel::PriorSizes> optional;
  /// Zhang's formulas on his procedure: weights from the sensors' noise alone, the gyros' bias in turns apart, and the rests of turns only in their
  /// sums.
  bool classical = false;
};

/// Of the procedure's only recording; `terms` as CalibrationOptions has them. Throws Error where the procedure is not one of a turntable, its steps
/// are wrong, or the unit's noise is not declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});
/// Of Zhang's model: offsets and matrices alone, by his weights.
Plan classical(Plan plan);

/// The source for coefficients that the procedure does not determine: they keep their starting values, and may be off by their prior.
inline constexpr const char* undetermined_source = "undetermined coefficients";

/// A term that the IMU may have, as a source of error: the part of it that the readings do not show.
struct TermSource {
  std::string name;        ///< among the sources: "accel.quadratic"
  CoefficientIndex first;  ///< its coefficient of the x axis
  double prior = 0;        ///< one sigma of each of its coefficients [SI]
};

/// Rows and elements are in the order of `coefficients`. `sigma` contains the second order, `cramer_rao` does not.
struct Prediction : imulab::Prediction {
  std::vector<std::string> sources;  ///< "orthogonality", "angle", "zero", "timing", "gravity", ...: columns of `variance`
  std::vector<TermSource> terms;     ///< those among them
  Eigen::MatrixXd variance;          ///< to first order, by source
  Eigen::VectorXd second_order;      ///< sigma of the second-order part
  Eigen::VectorXd bias;              ///< mean of the second-order part, which `calibrate` subtracts
  Eigen::VectorXd first_order() const { return variance.rowwise().sum().cwiseSqrt(); }
};

Prediction predict(const Plan& plan);
/// For the table of methods.
imulab::Prediction predict(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});

struct MonteCarloResult {
  std::vector<CoefficientIndex> coefficients;
  std::uint64_t runs = 0;
  Eigen::VectorXd mean;            ///< of the errors
  Eigen::VectorXd sigma;           ///< root mean square error
  Eigen::VectorXd sampling_sigma;  ///< standard deviation of `sigma`, relative
};

/// Whole procedures with drawn table errors, g, terms with a prior, and noise, each calibrated, at the level of rest means and turn sums. Bit-equal
/// on any number of threads and processes. `progress` is called with the number of finished runs, from any thread.
MonteCarloResult monte_carlo(const Plan& plan, std::uint64_t runs, std::uint64_t seed, const std::function<void(std::uint64_t)>& progress = {},
                             const Checkpoint* checkpoint = nullptr);

}  // namespace imulab::turntable
