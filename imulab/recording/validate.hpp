// The largest reading of any sensor.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <string_view>

namespace imulab {

/// No sensor gives more: 10,000 g, a thousand turns a second, or counts of 48 bits. `unit`: "m/s^2", "rad/s" or "count".
double largest_reading(std::string_view unit);

}  // namespace imulab
