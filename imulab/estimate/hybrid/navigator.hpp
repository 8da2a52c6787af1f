// Velocity and attitude of a unit by its compensated readings, block by block, with the integrals that the error equations need.
#pragma once

#include "imulab/estimate/hybrid/blocks.hpp"
#include "imulab/estimate/hybrid/error_equations.hpp"
#include "imulab/navigation/integration/increment.hpp"

namespace imulab::hybrid {

/// The recording without its model's errors. Lever arms are removed from the motions; at rest there is no size effect, and what the gyros' noise
/// would make of one is correlated with what it does to the attitude.
Recording compensated(const Recording& recording, const std::vector<Block>& blocks, const SensorModel& model);

class Navigator {
 public:
  Navigator(const Recording& compensated, const Place& place, const States& states);

  Matrix3d C_nb = Matrix3d::Identity();

  /// Levels from the mean force, heading from the mean rate where its horizontal part shows the Earth's.
  void align(const Range& range);

  /// `first`: the sample since which the motion was seen without a break.
  BlockSums over(const Block& block, std::size_t first);

 private:
  void add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block);

  const Recording& recording_;
  const States& states_;
  Vector3d earth_rate_, gravity_;
  Increment previous_;
};

}  // namespace imulab::hybrid
