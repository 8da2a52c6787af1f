// Checks records of aids for values that were not measured, before the filter uses them.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::aided {

/// Removes values that a receiver did not measure and adds findings to `out`, a doubt if they are most of its positions: rows with latitude and
/// longitude 0; positions that are repeated exactly at least five times, together with a repeated nonzero velocity; and positions at the start from
/// which no motion leads to the others. Names an aid far from the initial state or site. Doubts readings at a limit. Throws Error if a receiver's
/// displacements fit its velocities only with latitude and longitude swapped.
void take_unmeasured(std::vector<Aid>& aids, const Session& session, const Recording& recording, AidedNavigation& out);

}  // namespace imulab::aided
