// Rests that were found and rejected: data that are lost.
#pragma once

#include "imulab/recording/rests_of_view.hpp"

#include <cstddef>
#include <string>

namespace imulab {

struct LostRests {
  std::size_t moving = 0;   ///< quiet runs rejected because no sensor at rest changes as much
  std::size_t shifted = 0;  ///< quiet runs rejected because the gyros read another zero there
  std::string motion = {};  ///< how much the longest of those that move does
};

/// As detect_rests without it.
RestDetection detect_rests(const RecordingView& recording, const RestOptions& options, LostRests& lost);
/// As rests_of without it; none where the session declares holds.
Rests rests_of(const RecordingView& recording, const Session& session, LostRests& lost, const RestOptions& options = {});

}  // namespace imulab
