// The [errors] table of a mission: an error specification in data sheet units.
#pragma once

#include "imulab/analysis/error_specification.hpp"
#include "imulab/io/toml_fields.hpp"

namespace imulab {

void describe(TomlFields& fields, ErrorSpecification& errors);

}  // namespace imulab
