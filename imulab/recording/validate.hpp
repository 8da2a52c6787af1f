// Checks a recording; every estimator does this before it computes anything.
#pragma once

#include "imulab/recording/recording.hpp"

namespace imulab {

/// Throws Error, naming the column, the sample and what was expected, for: no samples; columns of another length than the stamps; stamps that go back
/// or repeat; a reading or temperature that is NaN or infinite; units other than "count", "rad/s" (gyro) and "m/s^2" (accel); an interval that is not
/// positive, or that differs from the stamps' differences outside gaps by more than 2 % (in median and mean); gaps or saturated samples that are out
/// of range or not ascending. One pass over the columns.
void validate(const Recording& recording);

}  // namespace imulab
