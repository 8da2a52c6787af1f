// One axis that repeats its reading for a while, as a sensor or a driver that hangs does.
#pragma once

#include "imulab/recording.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Stretches in which a column repeats one reading although its readings change before and after, and chance does not explain it. Nothing is said of
/// readings at their extremes (a limit), and of a column in which a tenth of the readings repeat the one before: these are coarse, or an ideal IMU's.
std::vector<Range> stuck_stretches(std::span<const double> readings);

/// "gyro.x repeats one reading for up to 8 samples, 25 times, ..., the first at 12.3 s"; empty where no axis is stuck.
std::string said_of_stuck(const Recording& recording);
/// "repeats one reading for up to 8 samples, 25 times, while those before and after change".
std::string said_of_stuck(const std::vector<Range>& stretches);

}  // namespace imulab
