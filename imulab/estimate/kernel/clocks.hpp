// The clocks of a recording and of its steps, where they are not one.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/rig/clock_offset.hpp"
#include "imulab/session.hpp"

#include <cmath>
#include <span>
#include <string>
#include <vector>

namespace imulab::kernel {

/// By how much a recording's clock gains on that of its steps.
struct ClockGain {
  std::string recording;
  ClockRate clock;
  bool increments = false;  ///< of the gyros

  bool significant() const { return std::abs(clock.rate) >= 5 * clock.sigma; }
};

/// Moves the steps of recordings whose rig's log has another clock, and says so; the gains that the steps show.
std::vector<ClockGain> correct_clocks(Session& session, std::span<const Recording> recordings, std::vector<std::string>& said);

/// States whose seconds the gyros' scales are in, and what is known of that clock: by the prior (50 ppm for a clock that stamped, 2 % where the rate
/// is only nominal: docs/reference/conventions.md) and by the steps' times. With [imu] clock = "true" the gyros' model becomes that of true seconds,
/// as uncertain as the clock.
void state_clock(Calibration& calibration, const Session& session, const std::vector<ClockGain>& gains);

/// Samples that were lost without a trace in the stamps are missing in the turns: doubtful where the turns come too early at once. A clock that
/// evenly loses is none of increments' concern, unless it loses more than clocks do, and more than the gyros' scales are stated to be known.
void doubt_clock(Calibration& calibration, const ClockGain& gain);

}  // namespace imulab::kernel
