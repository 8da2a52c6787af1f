// The clocks of a recording and of its steps, where they are not one.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/clock_offset.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab::kernel {

/// A recording whose clock gains on that of its steps by more than chance.
struct ClockGain {
  std::string recording;
  ClockRate clock;
  bool increments = false;  ///< of the gyros
};

/// Moves the steps of recordings whose rig's log has another clock, and says so.
std::vector<ClockGain> correct_clocks(Session& session, std::span<const Recording> recordings, std::vector<std::string>& said);

/// One of the two clocks is wrong. If it is the recording's, so are the scales of gyros that read rates, by as much; if samples were lost without a
/// trace in the stamps, so are those of increments. Doubtful where they are stated to be better known.
void doubt_clock(Calibration& calibration, const ClockGain& gain);

}  // namespace imulab::kernel
