// The start of whole-unit calibration: the readings' center, a linear model, and whether the IMU was mounted as the session says.
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/rig/machine_points.hpp"

namespace imulab::whole_unit {

/// Offset-binary counts are centered on the middle of their range, so that powers of them remain distinguishable; other readings stay as they are.
Vector6d reading_center(const MachinePoints& points);

/// Of readings less `center`. Readings in SI start from the identity, counts from linear least squares over all points. Throws
/// Unsupported where that does not determine a scale of counts.
SensorModel starting_model(const MachinePoints& points, const Session& session, const Vector6d& center);

/// Throws Error where the readings of a mount contradict it and another mount, or the opposite rate, explains them.
void check_mounts(const MachinePoints& points, const Session& session, const SensorModel& start, const Vector6d& center);

}  // namespace imulab::whole_unit
