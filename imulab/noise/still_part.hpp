// The part of a recording that contains only noise of the IMU: at rest, without interruption.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab {

/// The longest part at rest without a gap or a saturated sample. If there are so many gaps of up to a second that a part across them is more than
/// four times as long, that part. A part shorter than 30 s or 1024 samples is insufficient.
struct StillRange {
  Range range;                     ///< samples of the recording
  std::vector<std::string> notes;  ///< excluded parts with reasons
  double interval_s = 0;           ///< interval of its samples: nominal, or of an even clock if stamps scatter
};

/// The numbers of samples that were outliers, and that were lost.
struct RepairedSamples {
  std::size_t replaced = 0, filled = 0;
};

/// Returns the part at rest of a valid recording in memory or on disk, of which samples were repaired. The holds of the session are the rests if
/// there are any, else rests are found. Throws Unsupported if no part is long enough: in motion, interrupted, saturated or short; throws Error like
/// detect_rests.
StillRange still_range(const RecordingView& recording, const Session& session, const RepairedSamples& repaired = {});

/// Returns true if so few samples are lost that filling them in does not change the noise.
bool worth_filling(const RecordingView& recording);

struct StillPart : StillRange {
  Recording recording;  ///< whole recording; outliers replaced, lost samples filled in one or two at a time; interval as for the part
};

/// Returns the part at rest of any recording in memory.
StillPart still_part(Recording recording, const Session& session);

}  // namespace imulab
