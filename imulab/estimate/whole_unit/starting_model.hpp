// The start of whole-unit calibration: the readings' center, a linear model, and whether the unit was mounted as the session says.
#pragma once

#include "imulab/estimate/whole_unit/points.hpp"
#include "imulab/model/sensor_model.hpp"

namespace imulab::whole_unit {

/// Offset-binary counts are centered on the middle of their range, so that powers of them remain distinguishable; other readings stay as they are.
Vector6d reading_center(const Points& points);

/// Of readings less `center`. Readings in SI start from the identity, counts from linear least squares over all points. Throws
/// Unsupported where that does not determine a scale of counts.
SensorModel starting_model(const Points& points, const Session& session, const Vector6d& center);

/// Throws Error where the readings of a mount contradict it and another mount, or the opposite rate, explains them.
void check_mounts(const Points& points, const Session& session, const SensorModel& start, const Vector6d& center);

/// A model of readings less `center` as one of the readings themselves; linear in the coefficients.
SensorModel uncentered(const SensorModel& model, const Vector6d& center);

}  // namespace imulab::whole_unit
