// A recording of an IMU that turns in one place, cut into blocks: at the end of each its velocity is known to be zero.
#pragma once

#include "imulab/recording/recording.hpp"

#include <string>
#include <vector>

namespace imulab::in_place {

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

}  // namespace imulab::in_place
