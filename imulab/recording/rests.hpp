// The rests of a recording: declared by the session's steps, or found in the data.
#pragma once

#include "imulab/recording/rest_detection.hpp"
#include "imulab/recording/session.hpp"

#include <string>
#include <vector>

namespace imulab {

struct Rests {
  std::vector<Range> ranges;
  std::vector<std::string> notes;  ///< their source, and the thresholds used
};

/// The holds of the steps that belong to the recording, less a tenth of a second at both ends (a twentieth of short ones, nothing
/// at less than 20 Hz); where it has none, the rests that detect_rests finds, less those inside a turn that the steps
/// declare. Throws Error for steps of machines: a rate table, centrifuge or chamber.
Rests rests_of(const Recording& recording, const Session& session);
/// Of a recording that is valid.
Rests rests_of(const RecordingView& recording, const Session& session);

}  // namespace imulab
