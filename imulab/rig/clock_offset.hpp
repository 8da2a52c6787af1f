// Clocks of a table's log and of the IMU: by how much the one is ahead of the other, and gains.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <span>

namespace imulab {

/// The time to add to the steps' times to get times of the recording's clock.
struct ClockOffset {
  double offset_s = 0, sigma_s = 0;
  double correlation = 0, uncorrected = 0;  ///< of the rate's size with the commanded one: with the offset, and without
};

/// The maximum of the correlation of |rate| with the commanded rates, refined by a parabola, its sigma from the curvature
/// (docs/reference/recordings.md, "steps at other times than the motion"). Empty where the clocks agree, where fewer than three turns are commanded,
/// and where the recording does not turn or has gaps.
std::optional<ClockOffset> clock_offset(const Recording& recording, std::span<const Step> steps);

/// By how much the recording's clock gains on that of the steps, as a fraction: also where samples were lost and have no stamps, which makes it lose.
struct ClockRate {
  double rate = 0, sigma = 0;
  double at_s = 0, late_s = 0;  ///< how late a turn is in the recording that the steps have at `at_s`
  std::size_t turns = 0;        ///< that it was found by
  double lost_s = 0;            ///< by which all later turns come too early at once, besides a line: no clock does that

  double late(double step_s) const { return late_s + rate * (step_s - at_s); }
};

/// By a line through how late the commanded turns are, from the times at which |rate| passes half of its maximum. Empty with fewer than six turns in
/// the data where the steps have them (to 1 s, in long turns to 5 s), and where their ends do not move as their beginnings do.
std::optional<ClockRate> clock_rate(const Recording& recording, std::span<const Step> steps);

}  // namespace imulab
