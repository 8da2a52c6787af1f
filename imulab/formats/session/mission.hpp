// Mission files: TOML -> Mission and, where there is one, the specification of its errors (docs/reference/navigate.md).
#pragma once

#include "imulab/navigation/budget/specification.hpp"
#include "imulab/navigation/motion/mission.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

struct MissionFile {
  motion::Mission mission;
  std::optional<ErrorSpecification> errors;
  std::vector<std::filesystem::path> files;  ///< that it names
  std::string sha256;                        ///< of its text
};

/// Reads a mission, and the file of its track. Throws Error with file, line and key: for unknown keys, kinds and units, values out of range, and
/// segments that the motion before them does not allow.
MissionFile read_mission(const std::filesystem::path& path);
/// Reads a mission from text; `path` is its name in messages, and files that it names are beside it.
MissionFile parse_mission(std::string_view text, const std::filesystem::path& path);

struct ErrorSourcesReading {
  ErrorSources sources;
  std::vector<std::string> warnings;
};

/// The sources of a mission's [errors] table, with the calibration it names beside the mission's file. Throws Error with the mission's name in front.
ErrorSourcesReading read_error_sources(const ErrorSpecification& specification, const std::filesystem::path& mission);

}  // namespace imulab
