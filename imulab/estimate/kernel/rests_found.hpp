// The rests that a method uses, and findings about rejected ones.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"

namespace imulab::kernel {

/// Like rests_of, with its notes. Rejected rests cause a warning, or a doubt if they are more than a fifth of all.
std::vector<Range> rests_found(const CalibrationInput& input, const Recording& recording, Findings& findings, const RestOptions& options = {});

}  // namespace imulab::kernel
