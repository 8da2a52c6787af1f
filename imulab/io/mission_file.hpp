// Mission files: TOML -> Mission (docs/trajectory.md).
#pragma once

#include "imulab/navigation/mission.hpp"

#include <filesystem>

namespace imulab {

/// Reads a mission, and the file of its track. Throws Error naming file, line, field and what was expected; unknown keys, kinds and units are
/// errors, and segments that the motion so far does not allow.
Mission read_mission(const std::filesystem::path& path);

}  // namespace imulab
