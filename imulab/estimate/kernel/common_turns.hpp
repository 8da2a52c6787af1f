// Do the gyros turn with the accelerometers? Those of another recording, or on another clock, do not, and no method can say anything of them.
#pragma once

#include "imulab/estimate/kernel/rest_start.hpp"

#include <optional>

namespace imulab::kernel {

/// How much of gravity's turning in the IMU from rest to rest the gyros explain: 1 all, 0 as little as gyros that read nothing. Turns of less than
/// 10 deg, with a gap or with saturated samples do not count; empty where fewer than three others are. `gyro`: the matrix of scaled readings.
std::optional<double> explained_turning(const Recording& recording, const RestStart& start, const Matrix3d& gyro);

/// The coarse matrix; nothing where it is not that of the declared IMU and the declared unit explains the turns better (gyros that are late by part
/// of a turn make any), or where the turns that would tell were lost. Throws Unsupported where the gyros explain less than half, with the coarse
/// matrix and, where their unit is declared, as they are.
std::optional<Matrix3d> with_common_turns(const Recording& recording, const RestStart& start, const std::optional<Matrix3d>& coarse);

}  // namespace imulab::kernel
