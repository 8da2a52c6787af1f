// What an aided navigation will state of a known motion, before it is driven: the filter and the smoother, linearized about it.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::aided {

/// What an ideal IMU reads, as means over the intervals.
Recording ideal_readings(const motion::NominalMotion& motion);

/// The constants, factors and covariance that navigate_under will state of this motion, in as many passes, by an IMU whose noise is that of the
/// priors; values are those declared. It is linearized about the motion itself; of the data, which are those of ideal sensors with noise and the
/// aids' records, with errors drawn, the sizes of the noise alone follow. Throws Error as navigate_under does.
AidedNavigation foresee(const SensorPriors& priors, const Session& session, const motion::NominalMotion& motion, const std::vector<Aid>& aids,
                        int passes, const OutputTerms* terms = nullptr);

}  // namespace imulab::aided
