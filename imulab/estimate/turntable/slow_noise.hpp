// Declared noise that is not white, in the holds' means and the turns' sums.
#pragma once

#include "imulab/model/noise.hpp"
#include "imulab/rig/table_motion.hpp"

#include <Eigen/Core>

namespace imulab::turntable {

/// Covariance of a part's mean (holds) or integral (turns) on one axis, in the unit of the noise; parts x parts: quantization, and bias instability,
/// walk and ramp about their mean over all parts, which belongs to the offset of this recording. Empty where no such noise is declared.
Eigen::MatrixXd slow_noise(const TableMotion& motion, const NoiseModel& noise, double interval_s);

}  // namespace imulab::turntable
