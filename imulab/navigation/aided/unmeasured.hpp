// What aids' records hold that was not measured, before the filter takes it.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::aided {

/// Takes away what a receiver did not measure, and says so in `out`; a doubt where that is most of its positions: rows of latitude and longitude 0;
/// positions that repeat the one before exactly, five times in a row or more, and with them a velocity that repeats and is not zero; and at the begin
/// of the navigation positions from which no motion leads to the others. Names an aid that is nowhere near the initial state or the site. Doubts
/// readings at a limit. Throws Error where a receiver's displacements fit its velocities with latitude and longitude swapped alone.
void take_unmeasured(std::vector<Aid>& aids, const Session& session, const Recording& recording, AidedNavigation& out);

}  // namespace imulab::aided
