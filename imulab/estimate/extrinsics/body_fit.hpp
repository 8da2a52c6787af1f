// The fit of a body's motion, mountings and IMUs to their recordings, from start to convergence.
#pragma once

#include "imulab/estimate/extrinsics/motion_fit.hpp"
#include "imulab/extrinsics.hpp"

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::extrinsics {

/// How errors of a calibration's coefficients change its output, a row for each of an IMU's columns: d(M raw + W) = dM M^-1 (output - W) + dW for each
/// triad, and the g-sensitivity. The offsets' rows are zero without `offsets`.
Eigen::MatrixXd errors_by_coefficients(const Calibration& calibration, bool offsets);

/// What is hardly more certain than before the motion.
std::vector<std::string> not_shown(const Mounting& mounting);

struct BodyFit {
  std::optional<MotionFit> fit;          ///< always there
  std::vector<Prior> covariance_before;  ///< of each IMU's errors before the motion
  ConstantsCovariance constants;
  bool converged = false;
  std::vector<BodyResidual> residuals;  ///< of each IMU
  std::vector<double> agreement;        ///< of each IMU but the first, as Extrinsics has it
  double duration = 0, used = 0;        ///< s in common, and used

  /// The mounting of an IMU but the first relative to it.
  Mounting mounting(std::size_t imu, const std::vector<BodyImu>& imus) const;
  /// The rates of an IMU but the first differ from those of the first by this fraction of the motion; adds a doubt if it is large.
  void judge_agreement(std::size_t imu, const std::vector<BodyImu>& imus, const BodyRates& rates, Findings& findings) const;
  /// Adds that the seconds scatter more than the noise explains in constants of an IMU: `size` from the column `first` on.
  void judge_scatter(const Mounting& mounting, Eigen::Index first, Eigen::Index size, Findings& findings) const;
  /// Adds what contradicts the mounting or is not shown.
  static void judge_mounting(const Mounting& mounting, Findings& findings);
};

struct FitOptions {
  double most_used_s = 120;         ///< of the motion
  bool first_is_reference = false;  ///< its offsets are known: by its calibration, or to the size of its grade
  std::function<void(double)> progress = {};
};
/// Throws as estimate_extrinsics does.
BodyFit fit_body(const std::vector<BodyImu>& imus, const FitOptions& options, Findings& findings);

}  // namespace imulab::extrinsics
