// The uncertainty of a hybrid calibration before any data, and the turns that would improve it: the covariance of its filter along the procedure's
// exact motion (docs/theory/strapdown.md). It is the Cramer-Rao bound of the method's linear model.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/hybrid/states.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/rig/pose_on_table.hpp"

#include <vector>

namespace imulab::hybrid {

/// The input of a calibration besides its data. The IMU is an ideal one with SI readings and this noise.
struct Plan {
  Session procedure;
  Place place;
  Noise noise;
  Terms terms;                  ///< those of a calibration of this procedure
  bool observe_motion = false;  ///< on a turntable the velocity is zero while it turns, too
  bool effects = false;         ///< as CalibrationOptions has it; not in `advise` and in the search for a path, which would take too long
};

/// The plan of a procedure with one recording; `terms` as CalibrationOptions has them. Throws Error where the latitude or the IMU's noise is not
/// declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});

/// Determined and undetermined coefficients as in `calibrate`; `cramer_rao` equals sigma if every coefficient is determined.
struct FilterPrediction : Prediction {
  States states;
  Eigen::MatrixXd covariance;  ///< of the filter's states at the end
  PoseOnTable end;             ///< pose of the table at the end
};

/// Throws Error where the procedure's steps are wrong or include no hold.
FilterPrediction predict(const Plan& plan);

/// Predicts a procedure, with advice where it misses a requirement or does not determine a coefficient.
Prediction predict(const Session& procedure, const PredictionOptions& options);

/// Throws Error where a required coefficient is not among those that the method estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// The turns that help most, where the procedure ends.
Advice advise(const Plan& plan, const FilterPrediction& prediction, const std::vector<Requirement>& requirements = {});

}  // namespace imulab::hybrid
