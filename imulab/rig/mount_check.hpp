// Was the IMU mounted on a machine as the session says? Another mount, or turning the other way, may explain its readings better.
#pragma once

#include "imulab/rig/machine_points.hpp"

#include <span>

namespace imulab::rig {

/// Points of one mounting, and what the IMU measured at each of them, to some percent. Throws Error where another mount or sense of rotation explains
/// that and the declared one does not.
void expect_declared_mount(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session);

}  // namespace imulab::rig
