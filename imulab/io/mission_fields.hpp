// The motion of a mission file: everything but its format.
#pragma once

#include "imulab/io/toml_fields.hpp"
#include "imulab/navigation/mission.hpp"

#include <filesystem>

namespace imulab {

/// `path`: the mission's file, beside which a track's is looked for.
void describe(TomlFields& fields, Mission& mission, const std::filesystem::path& path);

}  // namespace imulab
