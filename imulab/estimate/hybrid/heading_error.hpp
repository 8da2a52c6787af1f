// The heading from all rests: at the start, for gyros that hardly resolve the Earth's rate in one rest; and whether it changes in the rests.
#pragma once

#include "imulab/estimate/hybrid/filter.hpp"

#include <optional>
#include <vector>

namespace imulab::hybrid {

/// The heading error at the start [rad] and its rate [rad/s]: a g-sensitivity that is equal on all axes turns the heading.
struct HeadingError {
  double start, rate;
};

/// Estimates the heading error for any initial heading and for a turning one, from gyros that hardly resolve the Earth's rate in one rest: the error
/// for which the sum of the rates of all rests is largest. Returns nothing if this sum is not five times the sum of their noise.
std::optional<HeadingError> heading_error(const std::vector<RestRate>& rates, double most_rate);

/// Returns the Noise::angle that explains the scatter of the rests' headings beyond the gyros' noise: small motion of a yielding stand or a hand.
/// `angle`: the value with which `seen` was computed.
double noise_of_angle(const std::vector<SeenHeading>& seen, double angle);

}  // namespace imulab::hybrid
