// The rests that a method works on, with what was lost of them.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"

namespace imulab::kernel {

/// As rests_of, with its notes; rests that were rejected are dropped data: a warning, and where they are more than a fifth of all a doubt.
std::vector<Range> rests_found(const CalibrationInput& input, const Recording& recording, Findings& findings);

}  // namespace imulab::kernel
