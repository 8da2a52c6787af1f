// Clocks of a table's log and of the IMU: by how much the one is ahead of the other.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <optional>
#include <span>

namespace imulab {

/// What has to be added to the steps' times so that they are those of the recording's clock.
struct ClockOffset {
  double offset_s = 0, sigma_s = 0;
  double correlation = 0, uncorrected = 0;  ///< of the rate's size with the commanded one: with the offset, and without
};

/// The maximum of the correlation of |rate| with the commanded rates, refined by a parabola, its sigma from the curvature (methods section 10,
/// clocks). Empty where the clocks agree, where fewer than three turns are commanded, and where the recording does not turn or has gaps.
std::optional<ClockOffset> clock_offset(const Recording& recording, std::span<const Step> steps);

}  // namespace imulab
