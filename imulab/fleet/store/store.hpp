// The version of a fleet's store, and its clock.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/fleet/store/database.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::fleet {

inline constexpr int store_version = 1;
double now();  ///< s since 1970

}  // namespace imulab::fleet
