// Where whole-unit calibration starts: the readings' center, a linear model, and whether the unit was mounted as the session says.
#pragma once

#include "imulab/estimate/whole_unit_points.hpp"
#include "imulab/model/sensor_model.hpp"

namespace imulab {

/// Offset-binary counts are centered on the middle of their range, so that powers of them stay apart; other readings stay as they are.
Vector6d reading_center(const WholeUnitPoints& points);

/// Readings in SI start from the identity, counts from linear least squares of everything the machines did. Throws Unsupported where that leaves a
/// scale of counts open.
SensorModel start_model(const WholeUnitPoints& points, const Session& session, const Vector6d& center);

/// Throws Error where the readings of a mount contradict it and another mount, or the opposite rate, explains them.
void check_mounts(const WholeUnitPoints& points, const Session& session, const SensorModel& start, const Vector6d& center);

/// A model of readings less `center` as one of the readings themselves; linear in the coefficients.
SensorModel uncentered(const SensorModel& model, const Vector6d& center);

}  // namespace imulab
