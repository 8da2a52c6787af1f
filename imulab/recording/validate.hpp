// Checks a recording and a session; every estimator does this before it computes anything.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <string_view>

namespace imulab {

/// No sensor gives more: 10,000 g, a thousand turns a second, or counts of 48 bits. `unit`: "m/s^2", "rad/s" or "count".
double largest_reading(std::string_view unit);

/// Throws Error, naming the column, the sample and what was expected, for: no samples; columns of another length than the stamps; stamps that go back
/// or repeat; a reading or temperature that is NaN or infinite; a reading beyond largest_reading; units other than "count", "rad/s" (gyro) and
/// "m/s^2" (accel); an interval that is not positive, or that differs from the stamps' differences outside gaps by more than 2 % (in median and
/// mean); gaps or saturated samples that are out of range or not ascending. One pass over the columns.
void validate(const Recording& recording);

/// Throws Error that lists every number of a session outside the range that a session file allows (latitude in -90 to 90 deg, a gravity in m/s^2,
/// noise of at least 0, ...), and every step that ends before it begins, begins before the end of the one before it, or turns nowhere.
void validate(const Session& session);

}  // namespace imulab
