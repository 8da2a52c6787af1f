// How good a hybrid calibration will be, before any data, and what would improve it: the covariance of its filter along the procedure's exact motion
// (docs/predict.md). It is the Cramer-Rao bound of the method's linear model.
#pragma once

#include "imulab/estimate/hybrid/states.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/rig/pose_on_table.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab::hybrid {

/// The input of a calibration besides its data. The IMU is an ideal one with SI readings and this noise.
struct Plan {
  Session procedure;
  Place place;
  Noise noise;
  Terms terms;                  ///< those of a calibration of this procedure
  bool observe_motion = false;  ///< on a turntable the velocity is zero while it turns, too
};

/// Of a procedure with one recording; `terms` as CalibrationOptions has them. Throws Error where the latitude or the IMU's noise is not declared.
Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});

/// Determined and undetermined coefficients as in `calibrate`; `cramer_rao` equals sigma if every coefficient is determined.
struct Prediction : imulab::Prediction {
  States states;
  Eigen::MatrixXd covariance;  ///< of the filter's states at the end
  PoseOnTable end;             ///< pose of the table at the end
};

/// Throws Error where the procedure's steps are wrong or include no hold.
Prediction predict(const Plan& plan);

/// The same, for the table of methods.
imulab::Prediction predict(const Session& procedure, const std::vector<CoefficientIndex>& terms = {});

/// Throws Error where a required coefficient is not among those that the method estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// The worst-determined direction: a combination of coefficients, each in units of its requirement (or of half its prior), and the further turns, one
/// or two of 90 or 180 deg about the table's axes at the end of the procedure, that help most.
struct Advice {
  std::vector<CoefficientIndex> coefficients;  ///< with a large part in it, the largest first
  double ratio = 0;                            ///< sigma along it, in those units
  std::vector<std::string> turns;              ///< "turn by 180 deg about the IMU's z axis while it is horizontal"; each with a rest after it
  double ratio_after = 0;                      ///< the largest ratio with them
};
Advice advise(const Plan& plan, const Prediction& prediction, const std::vector<Requirement>& requirements = {});

}  // namespace imulab::hybrid
