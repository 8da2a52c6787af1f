// Do the gyros turn with the accelerometers? Those of another recording, or on another clock, do not, and no method can say anything of them.
#pragma once

#include "imulab/estimate/kernel/rest_start.hpp"

#include <optional>

namespace imulab::kernel {

/// The gyros' coarse matrix in motion (coarse.hpp); nothing where it is not that of the declared IMU and the declared unit explains the turns better
/// (gyros that are late by part of a turn make any), or where the turns that would tell were lost. Throws Unsupported where the gyros explain less
/// than half, with the coarse matrix and, where their unit is declared, as they are.
std::optional<Matrix3d> coarse_gyro_in_common_turns(const Recording& recording, const RestStart& start);

}  // namespace imulab::kernel
