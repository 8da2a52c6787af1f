// Velocity and attitude of an IMU that turns in one place, by its compensated readings block by block, with the sums that the error equations need.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/in_place/error_sums.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/compensated_readings.hpp"

#include <string>
#include <vector>

namespace imulab::in_place {

// A recording of an IMU that turns in one place, cut into blocks: at the end of each its velocity is known to be zero.

struct Block {
  Range samples;
  bool at_rest = false;
  bool observed = true;  ///< the velocity is zero at its end
  bool lost = false;     ///< the motion before it was not measured (a gap, a saturated sample): the attitude is aligned again
};

/// A table may still move that long after its step has ended, and before it begins [s].
inline constexpr double settling_time = 1;
/// The parts of rests during which the IMU is still: without settling_time at both ends, of rests that are longer than five times that.
std::vector<Range> still_parts(const Recording& recording, std::vector<Range> rests);

struct Blocks {
  std::vector<Block> blocks;
  std::vector<std::string> warnings;  ///< motions that were not measured: where, why, and what is lost
};

/// From the first rest to the last. Rests, in time order, are cut into seconds, motions into about fifths of a second. `observe_motion`: the IMU
/// stays in one place while it turns, too. A motion with a gap or a saturated sample is left out.
Blocks cut_into_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion);

/// Lever arms are removed from the motions; at rest there is no size effect, and what the gyros' noise would make of one is correlated with what it
/// does to the attitude.
class Navigator {
 public:
  /// Navigates readings with the errors of `model`, whose accelerometers measure the size effect by `delay` [s], at most a sample, later than the
  /// gyros the turn. Both must outlive it. `latitude` [rad], `gravity` [m/s^2].
  Navigator(const Recording& recording, const SensorModel& model, double delay, double latitude, double gravity, const OptionalSums& optional);

  Matrix3d C_nb = Matrix3d::Identity();
  CompensatedReadings readings;  ///< with the size effect

  /// Levels from the mean force, heading from the mean rate where its horizontal part shows the Earth's.
  void align(const Range& range);

  /// `first`: the sample since which the motion was seen without a break.
  BlockSums over(const Block& block, std::size_t first);

 private:
  void add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block);
  Vector3d angular_acceleration(std::size_t i);
  Vector3d force_at_origin(std::size_t i);

  const Recording& recording_;
  const Matrix3d& lever_arm_;
  double late_;  // of a sample
  OptionalSums optional_;
  Vector3d earth_rate_, gravity_;
  Increment previous_;
  Vector3d velocity_ = Vector3d::Zero();  // since it was last known to be zero
  Vector3d pushes_, squares_;             // of the block at rest: sums of the force beside that of gravity, and of its squares
};

}  // namespace imulab::in_place
