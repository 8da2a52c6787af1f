// What `budget` and `trajectory` share.
#pragma once

#include "imulab/analysis/error_specification.hpp"

#include <string>

namespace imulab::command {

/// The sources of a mission's [errors] table, with the calibration it names, beside the mission's file.
ErrorSources read_error_sources(const ErrorSpecification& specification, const std::string& mission);

}  // namespace imulab::command
