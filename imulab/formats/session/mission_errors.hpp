// The [errors] table of a mission file, in data sheet units (docs/budget.md).
#pragma once

#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/navigation/budget/specification.hpp"

namespace imulab::session_io {

using namespace text;

/// Throws Error with file, line and key.
void read_errors(TomlFields& fields, ErrorSpecification& errors);

}  // namespace imulab::session_io
