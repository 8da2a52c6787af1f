// A recording cut into the filter's blocks.
#pragma once

#include "imulab/estimate/hybrid_filter.hpp"

#include <string>
#include <vector>

namespace imulab {

struct HybridBlocks {
  std::vector<HybridBlock> blocks;
  std::vector<std::string> warnings;  ///< motions that were not seen: where, why, and what is lost
};

/// From the first rest to the last. Rests, in time order, are cut into seconds, motions into about fifths of a second. `observe_motion`: the unit
/// stays in its place while it turns, too. A motion with a gap or a saturated sample is left out, and the attitude begins anew at the rest after it.
HybridBlocks hybrid_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion);

}  // namespace imulab
