// Differences between the clock of a recording and the clock of its steps.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/rig/clock_offset.hpp"
#include "imulab/session.hpp"

#include <cmath>
#include <span>
#include <string>
#include <vector>

namespace imulab::kernel {

/// The rate by which a recording's clock gains on the clock of its steps.
struct ClockGain {
  std::string recording;
  ClockRate clock;
  bool increments = false;  ///< the gyros output increments

  bool significant() const { return std::abs(clock.rate) >= 5 * clock.sigma; }
};

/// Shifts the steps of recordings whose rig log has another clock and describes the shifts in `said`. Returns the estimated clock gains.
std::vector<ClockGain> correct_clocks(Session& session, std::span<const Recording> recordings, std::vector<std::string>& said);

/// States the time unit of the gyro scales and the uncertainty of that clock. It combines a prior (50 ppm for a clock that stamped the samples, 2 %
/// if the rate is only nominal: docs/reference/conventions.md) with the step times. With [imu] clock = "true", converts the gyro model to true
/// seconds and adds the uncertainty of the clock.
void state_clock(Calibration& calibration, const Session& session, const std::vector<ClockGain>& gains);

/// Doubts the calibration if the timing of turns implies samples that were lost without a gap in the stamps. An evenly slow clock matters only for
/// increments, and only if it loses more than real clocks do and more than the stated uncertainty of the gyro scales.
void doubt_clock(Calibration& calibration, const ClockGain& gain);

}  // namespace imulab::kernel
