// Declared noise with long correlation, in means over time: bias instability, rate random walk and ramp.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/grade.hpp"

#include <vector>

namespace imulab::kernel {

struct TimeSpan {
  double begin, end;  ///< s
  double middle() const { return 0.5 * (begin + end); }
};

/// Returns the covariance of one axis's means over these times, in the unit of the noise. Walk and ramp begin at time 0; bias instability is that of
/// the simulation at this sample interval. Empty if no such noise is declared.
Eigen::MatrixXd slow_noise(const std::vector<TimeSpan>& times, const NoiseModel& noise, double interval_s);

}  // namespace imulab::kernel
