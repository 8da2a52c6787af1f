// How good a hybrid calibration will be, before any data: the covariance of its filter along the procedure's exact motion (docs/predict.md).
// It is the Cramer-Rao bound of the method's linear model.
#pragma once

#include "imulab/estimate/hybrid_filter.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/turntable.hpp"

#include <Eigen/Core>

#include <vector>

namespace imulab {

/// What a procedure's calibration has to do with, besides its motion. The unit is an ideal one with SI readings and this noise.
struct HybridPlan {
  Session procedure;
  HybridSite site;
  HybridNoise noise;
  HybridTerms terms;            ///< the g-sensitivity where the grade has it
  bool observe_motion = false;  ///< on a turntable the velocity is zero while it turns, too
};

/// Of a procedure with one recording. Throws Error where the latitude or the unit's noise is not declared.
HybridPlan hybrid_plan(const Session& procedure);

/// What a calibration leaves out of a rest's beginning and end, where the rest is longer than five times that: a table may still move [s].
inline constexpr double hybrid_settling = 1;

struct HybridPrediction {
  std::vector<int> coefficients, undetermined;  ///< table indices, told apart as `calibrate` does
  Eigen::VectorXd sigma;                        ///< standard uncertainty of each of `coefficients`, SI
  Eigen::VectorXd cramer_rao;                   ///< the same where nothing is left undetermined: without what that does to the others
  Eigen::VectorXd remaining;                    ///< what the data leave of the prior of each of `undetermined`, SI
  HybridLayout layout;
  Eigen::VectorXd prior;       ///< standard deviations of the filter's constants before the data
  Eigen::MatrixXd covariance;  ///< of the filter's states at the end
  Matrix3d C_nb;               ///< attitude there, and
  RigAxes axes;                ///< the directions of the table's axes in n
};

/// Throws Error where the procedure's steps are wrong or hold no rest.
HybridPrediction predict(const HybridPlan& plan);

}  // namespace imulab
