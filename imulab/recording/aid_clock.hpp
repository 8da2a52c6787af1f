// The stamps of an aid on the clock of a recording.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab {

/// Of a guessed offset between two clocks, by their dates or their first stamps [s].
inline constexpr double guessed_offset_sigma = 1;

/// The aid with the stamps of its record on the recording's clock, each leap second where it was. The scale is then TimeScale::recording where the
/// clocks are known (an aid's of the recording's own time; gps or utc of both), and TimeScale::own where the offset between them remains to be
/// estimated: the stamps are then a first guess, by dates where they overlap, else so that both begin together; a note says so, and a declared
/// uncertainty of the delay contains that of the guess. Throws Error where the clocks are known and the record has no stamp within the recording's
/// time.
Aid on_recording_clock(Aid aid, const Recording& recording, const RecordingSource& source, std::vector<std::string>& notes);

}  // namespace imulab
