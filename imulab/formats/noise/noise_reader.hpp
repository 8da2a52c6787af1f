// The file that `imulab noise` writes, read back.
#pragma once

#include "imulab/model/imu_noise.hpp"

#include <string>
#include <string_view>

namespace imulab {

/// Throws Error that names file and field where it is no "imulab.noise/1".
ImuNoise read_noise(const std::string& path);
/// The same from text; `file` is its name in messages.
ImuNoise parse_noise(std::string_view text, const std::string& file);

}  // namespace imulab
