// Calibrations that may be applied.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab::command {

/// The option --allow-undetermined.
void add_allow_undetermined(Verb& verb, bool& allowed);

/// Prints the warnings of `usability`, and throws as that; and Unsupported, naming `file`, where offsets or matrices were not determined and so keep
/// starting values that compensate nothing; with `allowed` it warns.
void expect_usable(const Calibration& calibration, const std::string& file, bool allowed);

/// Reads the file and expects that.
Calibration read_usable(const std::string& file, bool allowed);

}  // namespace imulab::command
