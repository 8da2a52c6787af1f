// Mission files: TOML -> Mission and, where there is one, the specification of its errors (docs/trajectory.md, docs/budget.md).
#pragma once

#include "imulab/analysis/error_specification.hpp"
#include "imulab/navigation/mission.hpp"

#include <filesystem>
#include <optional>

namespace imulab {

struct MissionFile {
  Mission mission;
  std::optional<ErrorSpecification> errors;
};

/// Reads a mission, and the file of its track. Throws Error naming file, line, field and what was expected; unknown keys, kinds and units are
/// errors, and segments that the motion so far does not allow.
MissionFile read_mission(const std::filesystem::path& path);

}  // namespace imulab
