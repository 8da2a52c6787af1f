// Velocity and attitude of an IMU that turns in one place, by its compensated readings block by block, with the sums that the error equations need.
#pragma once

#include "imulab/navigation/in_place/blocks.hpp"
#include "imulab/navigation/in_place/error_sums.hpp"
#include "imulab/navigation/integration/increment.hpp"

namespace imulab::in_place {

/// The recording without its model's errors. Lever arms are removed from the motions, as accelerometers measure them that are behind the gyros by
/// `delay` [s], at most a sample; at rest there is no size effect, and what the gyros' noise would make of one is correlated with what it does to the
/// attitude.
Recording compensated(const Recording& recording, const std::vector<Block>& blocks, const SensorModel& model, double delay = 0);

/// The sums that only some error models need.
struct OptionalSums {
  bool g_sensitivity = false, quadratic = false, lever_arm = false, delay = false;
};

class Navigator {
 public:
  /// `latitude` [rad], `gravity` [m/s^2].
  Navigator(const Recording& compensated, double latitude, double gravity, const OptionalSums& optional);

  Matrix3d C_nb = Matrix3d::Identity();

  /// Levels from the mean force, heading from the mean rate where its horizontal part shows the Earth's.
  void align(const Range& range);

  /// `first`: the sample since which the motion was seen without a break.
  BlockSums over(const Block& block, std::size_t first);

 private:
  void add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block);

  const Recording& recording_;
  OptionalSums optional_;
  Vector3d earth_rate_, gravity_;
  Increment previous_;
};

}  // namespace imulab::in_place
