// The [[segment]] tables of a mission file (docs/trajectory.md).
#pragma once

#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/navigation/motion/mission.hpp"

namespace imulab::session_io {

using namespace text;

/// Appends every segment to mission.segments; mission.start and mission.carrier have been read. Throws Error with file, line and key, also for a
/// segment that the motion before it does not allow.
void read_segments(TomlFields& fields, motion::Mission& mission);

}  // namespace imulab::session_io
