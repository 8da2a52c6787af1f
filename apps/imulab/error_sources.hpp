// Common to `budget` and `trajectory`.
#pragma once

#include "imulab/navigation/budget/specification.hpp"

#include <string>

namespace imulab::command {

/// The sources of a mission's [errors] table, with the calibration that it names, relative to the mission's file; prints its warnings.
ErrorSources mission_errors(const ErrorSpecification& specification, const std::string& mission);

}  // namespace imulab::command
