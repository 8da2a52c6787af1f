// The undeclared offset of a receiver's clock, at which turns and speed changes of both records agree.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/recording.hpp"

#include <vector>

namespace imulab::aided {

/// Shifts the stamps of receivers with clocks of their own to the best agreement of turn rate with course rate and of both horizontal accelerations,
/// among all offsets with half of the shorter record in common. Dates favor two offsets, their own and the other time scale's: within
/// guessed_offset_sigma, one of these is used as it is, and the remainder becomes a delay. `out` receives a finding for each shift. Nothing changes
/// if the motion does not determine the offset or the delay is declared. `recording` must be compensated. Throws Unsupported if two offsets fit.
void find_clocks(std::vector<Aid>& aids, const Recording& recording, const std::vector<Outage>& withheld, AidedNavigation& out);

}  // namespace imulab::aided
