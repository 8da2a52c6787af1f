// Declared noise that lasts longer than a sample, in means over times: bias instability, rate random walk and ramp.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/grade.hpp"

#include <vector>

namespace imulab::kernel {

struct TimeSpan {
  double begin, end;  ///< s
  double middle() const { return 0.5 * (begin + end); }
};

/// Covariance of one axis's means over these times, in the unit of the noise. Walk and ramp begin at the time 0; bias instability is as the
/// simulation draws it at this interval of the samples. Empty where no such noise is declared.
Eigen::MatrixXd slow_noise(const std::vector<TimeSpan>& times, const NoiseModel& noise, double interval_s);

}  // namespace imulab::kernel
