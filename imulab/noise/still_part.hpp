// The part of a recording in which an IMU shows its noise alone: at rest, without interruption.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab {

/// The longest stretch at rest without a gap or a saturated sample; where gaps of up to a second are so many that a stretch across them is more than
/// four times as long, that one. A shorter one than 30 s or 1024 samples says too little.
struct StillRange {
  Range range;                     ///< of the recording's samples
  std::vector<std::string> notes;  ///< what was cut, and why
  double interval_s = 0;           ///< of its samples: nominal, or of the even clock of stamps that scatter
};

/// The part at rest of a recording in memory or on disk, which is valid and of whose lost samples so many were filled. Where the session has holds,
/// they are the rests, else they are found. Throws Unsupported where no stretch is long enough: in motion, interrupted, saturated or short; Error as
/// detect_rests.
StillRange still_range(const RecordingView& recording, const Session& session, std::size_t filled = 0);

/// True where so few samples are lost that filling them in does not change the noise.
bool worth_filling(const RecordingView& recording);

struct StillPart : StillRange {
  Recording recording;  ///< the whole one; lost samples filled, one or two at a time; its interval that of the part
};

/// The part at rest of any recording in memory.
StillPart still_part(Recording recording, const Session& session);

}  // namespace imulab
