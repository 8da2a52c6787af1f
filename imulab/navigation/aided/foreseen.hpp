// Predicts the result of an aided navigation for a known motion: the filter and the smoother, linearized about it.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::aided {

/// Returns the readings of an ideal IMU as means over the intervals.
Recording ideal_readings(const motion::NominalMotion& motion);

/// Predicts the constants, factors and covariance of navigate_under for this motion with as many passes and an IMU with the noise of the priors;
/// values are the declared ones. The linearization is about the motion itself. Only the noise sizes depend on data: simulated readings of ideal
/// sensors with noise, and records of the aids with random errors. Throws Error like navigate_under.
AidedNavigation foresee(const SensorPriors& priors, const Session& session, const motion::NominalMotion& motion, const std::vector<Aid>& aids,
                        int passes, const OutputTerms* terms = nullptr);

}  // namespace imulab::aided
