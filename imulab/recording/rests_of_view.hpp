// Rests of a recording that is known to be valid, in memory or on disk.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

/// An IMU at rest on both sides of a shorter gap was at rest inside it.
inline constexpr double still_s = 0.25;

/// As above, for a recording that is known to be valid.
RestDetection detect_rests(const RecordingView& recording, const RestOptions& options = {});

/// As above, for a recording that is known to be valid.
Rests rests_of(const RecordingView& recording, const Session& session);

}  // namespace imulab
