// The offset of a receiver's clock that nobody declared: where turns and changes of speed fit.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/recording.hpp"

#include <vector>

namespace imulab::aided {

/// Moves the stamps of receivers whose clock is their own to where turn rate and course rate, and both horizontal accelerations, fit best, among all
/// offsets with half of the shorter record in common; dates speak for their own offset and for that of the other scale. Within guessed_offset_sigma
/// of one of these it is taken as it is, and the rest remains a delay. Says in `out` what was moved. Nothing changes where the motion does not tell,
/// or the delay is declared. `recording` is compensated. Throws Unsupported where two offsets compete.
void find_clocks(std::vector<Aid>& aids, const Recording& recording, const std::vector<Outage>& withheld, AidedNavigation& out);

}  // namespace imulab::aided
