// Velocity and attitude of an IMU that turns in one place, from its compensated readings block by block, with sums for the error equations.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/in_place/error_sums.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/compensated_readings.hpp"

#include <string>
#include <vector>

namespace imulab::in_place {

// A recording of an IMU that turns in one place, divided into blocks: the velocity at the end of each is known to be zero.

struct Block {
  Range samples;
  bool at_rest = false;
  bool observed = true;  ///< the velocity is zero at its end
  bool lost = false;     ///< the motion before it was not measured (a gap, a saturated sample): the attitude is aligned again
};

/// A table may move for this time after its step has ended, and before it begins [s].
inline constexpr double settling_time = 1;
/// Returns the still parts of rests: rests longer than five settling times without settling_time at both ends.
std::vector<Range> still_parts(const Recording& recording, std::vector<Range> rests);

struct Blocks {
  std::vector<Block> blocks;
  std::vector<std::string> warnings;  ///< motions that were not measured: place, reason and loss
};

/// Divides the recording from the first rest to the last. Rests, in time order, become blocks of a second, motions blocks of about a fifth of a
/// second. `observe_motion`: the IMU also stays in one place while it turns. Motions with a gap or a saturated sample are left out.
Blocks cut_into_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion);

/// Navigates in one place. Lever arms are removed only from motions: at rest there is no size effect, and a computed one would be gyro noise
/// correlated with the attitude.
class Navigator {
 public:
  /// Navigates readings with the errors of `model`. Its accelerometers measure the size effect with a `delay` [s] of at most one sample relative to
  /// the gyros. Recording and model must outlive the navigator. `latitude` [rad], `gravity` [m/s^2].
  Navigator(const Recording& recording, const SensorModel& model, double delay, double latitude, double gravity, const OptionalSums& optional);

  Matrix3d C_nb = Matrix3d::Identity();
  CompensatedReadings readings;  ///< including the size effect

  /// Aligns: level from the mean force, heading from the mean rate if its horizontal part contains the Earth's.
  void align(const Range& range);

  /// Integrates a block; `first` is the sample since which the motion was measured without interruption.
  BlockSums over(const Block& block, std::size_t first);

 private:
  void add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block);
  Vector3d angular_acceleration(std::size_t i);
  Vector3d force_at_origin(std::size_t i);

  const Recording& recording_;
  const Matrix3d& lever_arm_;
  double late_;  // in samples
  OptionalSums optional_;
  Vector3d earth_rate_, gravity_;
  Increment previous_;
  Vector3d velocity_ = Vector3d::Zero();  // relative to the last time when it was zero
  Vector3d pushes_, squares_;             // for a block at rest: sums of the force beyond gravity, and of its squares
};

}  // namespace imulab::in_place
