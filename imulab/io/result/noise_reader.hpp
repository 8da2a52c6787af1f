// The file that `imulab noise` writes, read back.
#pragma once

#include "imulab/model/imu_noise.hpp"

#include <string>

namespace imulab {

/// Throws Error that names file and field where it is no "imulab.noise/1".
ImuNoise read_noise(const std::string& path);

}  // namespace imulab
