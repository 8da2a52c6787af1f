// The uncertainty of a hybrid calibration before any data, and turns that would improve it: the covariance of its filter along the exact motion of
// the procedure (docs/theory/strapdown.md). It is the Cramer-Rao bound of the method's linear model.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/hybrid/states.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/rig/pose_on_table.hpp"

#include <vector>

namespace imulab::hybrid {

/// The input of a calibration other than its data. The IMU is ideal, with SI readings and this noise.
struct Plan {
  Session procedure;
  Place place;
  Noise noise;
  Terms terms;                  ///< terms of a calibration of this procedure
  bool observe_motion = false;  ///< on a turntable, the velocity is also zero during turns
  bool effects = false;         ///< as in CalibrationOptions; not used in `advise` and the path search, which would take too long
};

/// Returns the plan of a procedure with one recording; `terms` as in CalibrationOptions. Throws Error if the latitude or the noise is not declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});

/// A prediction with determined and undetermined coefficients as in `calibrate`; `cramer_rao` equals sigma if every coefficient is determined.
struct FilterPrediction : Prediction {
  States states;
  Eigen::MatrixXd covariance;  ///< covariance of the filter's states at the end
  PoseOnTable end;             ///< pose of the table at the end
};

/// Predicts a plan. Throws Error if the procedure's steps are wrong or include no hold.
FilterPrediction predict(const Plan& plan);

/// Predicts a procedure, with advice if it misses a requirement or does not determine a coefficient.
Prediction predict(const Session& procedure, const PredictionOptions& options);

/// Throws Error if the method does not estimate a required coefficient.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// Returns the turns at the end of the procedure that help most.
Advice advise(const Plan& plan, const FilterPrediction& prediction, const std::vector<Requirement>& requirements = {});

}  // namespace imulab::hybrid
