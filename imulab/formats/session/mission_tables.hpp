// Two kinds of tables of a mission file: [[segment]], the motion, and [errors], the sources of error in the units of
// data sheets (docs/reference/navigate.md). Errors have file, line and key in front.
//
//   [[segment]]
//   kind = "turn"
//   angle_deg = 90
//   rate_dps = 2
#pragma once

#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/navigation/budget/specification.hpp"
#include "imulab/navigation/motion/mission.hpp"

namespace imulab::session_io {

using namespace text;

/// Appends every segment to mission.segments; mission.start and mission.carrier have been read. Throws Error with file, line and key, also for a
/// segment that the motion before it does not allow.
void read_segments(TomlFields& fields, motion::Mission& mission);

/// Reads the [errors] table. Throws Error with file, line and key.
void read_errors(TomlFields& fields, ErrorSpecification& errors);

}  // namespace imulab::session_io
