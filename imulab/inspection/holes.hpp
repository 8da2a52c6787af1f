// Columns of numbers in which some rows have none.
#pragma once

#include "imulab/inspection/signals.hpp"

#include <string>

namespace imulab::inspection {

/// "; ax has no finite number in 3 of 90 rows, first in row 7", or of sensors whose rows were merged what to do; empty where there are none.
std::string words_about_holes(const SignalTable& table);

/// "gx, gy, gz have no finite number in 528 of 26400 rows, ...": of columns named as a sensor's axes, and not of merged rows; else empty.
std::string holes_of_sensors(const SignalTable& table);

}  // namespace imulab::inspection
