// The part of a recording in which an IMU shows its noise alone: at rest, without interruption.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/session.hpp"

#include <string>
#include <vector>

namespace imulab {

/// The longest stretch at rest without a gap or a saturated sample. A shorter one than 30 s or 1024 samples says too little.
struct StillPart {
  Recording recording;             ///< the whole one; lost samples filled, one or two at a time
  Range range;                     ///< of its samples
  std::vector<std::string> notes;  ///< what was cut, and why
};

/// Where the session has holds, they are the rests, else they are found. Throws Unsupported where no stretch is long enough: in motion, interrupted,
/// saturated or short; Error as detect_rests.
StillPart still_part(Recording recording, const Session& session);

/// The same of a recording in memory or on disk, which is valid and whose lost samples were filled.
struct StillRange {
  Range range;
  std::vector<std::string> notes;
  double interval_s = 0;  ///< of its samples: nominal, or of the even clock of stamps that scatter
};
StillRange still_range(const RecordingView& recording, const Session& session, std::size_t filled = 0);

}  // namespace imulab
