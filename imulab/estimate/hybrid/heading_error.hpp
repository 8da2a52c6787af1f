// What the rests tell of the heading: at the start, for gyros that hardly resolve the Earth's rate in one rest; and whether it stays in them.
#pragma once

#include "imulab/estimate/hybrid/filter.hpp"

#include <optional>
#include <vector>

namespace imulab::hybrid {

/// The heading's error at the start [rad], and its rate [rad/s]: an equal g-sensitivity on all axes turns the heading.
struct HeadingError {
  double start, rate;
};

/// From any heading, and one that turns: of gyros that hardly resolve the Earth's rate in one rest, that error of the heading with which the rates of
/// all rests add up to most. Nothing where that is not five times what their noise adds up to.
std::optional<HeadingError> heading_error(const std::vector<RestRate>& rates, double most_rate);

/// Where the headings of the rests scatter more than the gyros' noise lets them, they move a little: a stand that yields, a hand. Noise::angle with
/// which the scatter is what is expected; `angle`: the one that they were seen with.
double noise_of_angle(const std::vector<SeenHeading>& seen, double angle);

}  // namespace imulab::hybrid
