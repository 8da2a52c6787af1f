// What distinguishes a rest from steady motion: at rest, means over a second and more change no more than the noise of a sensor lets them.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Why a stretch is no rest, in words: its means over one or several seconds change by more than any sensor's noise, or its gyros turn faster than
/// any offset; empty where it may be a rest. Vibration is no motion: its means over a second stay. Of a stretch shorter than four seconds nothing is
/// said. Of counts: the accelerometers alone, and only where `counts_by_gravity` says that the mean of their readings is gravity.
std::string motion_in(const RecordingView& recording, const Range& range, bool counts_by_gravity = false);

/// The same by the accelerometers alone.
std::string motion_by_force(const RecordingView& recording, const Range& range, bool counts_by_gravity = false);

/// Why the readings of a rest are more than a sensor's noise: a part that vibrates, gyros that show a steady turn or a large offset. A sentence each;
/// SI only.
std::vector<std::string> doubts_about_rest(const RecordingView& recording, const Range& range);

}  // namespace imulab
