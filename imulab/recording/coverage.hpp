// The directions in which a recording shows gravity to the accelerometers: the contribution of each rest, and the directions without any.
#pragma once

#include "imulab/eigen.hpp"

#include <vector>

namespace imulab {

/// Counts, for each rest, how many of the nine accelerometer parameters in the accelerometers' frame (offsets, scales, misalignments) it determines,
/// all rests being equally good: the leverages of |force| = g, between 0 and 1, with the sum 9. At 1 no other rest checks it. Where the directions do
/// not determine a parameter, the sum is the number of those determined. Directions of any length above 0.
std::vector<double> leverages(const std::vector<Vector3d>& directions);

/// A direction that is far from every rest's.
struct CoverageGap {
  Vector3d direction;  ///< unit vector in the body: up, where the IMU would have to rest
  double angle = 0;    ///< to the nearest rest's [rad]
};

/// The farthest direction, then the farthest from it and all rests, and so on while the angle is above `least` [rad], at most `most` of them. None
/// where there is no direction.
std::vector<CoverageGap> coverage_gaps(const std::vector<Vector3d>& directions, double least, std::size_t most = 3);

}  // namespace imulab
