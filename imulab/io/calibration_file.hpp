// Calibration files: JSON <-> Calibration (docs/formats.md), validated on reading.
#pragma once

#include "imulab/model/calibration.hpp"

#include <filesystem>
#include <string>

namespace imulab {

/// Reads calibration.json or truth.json. Throws Error naming file, field and what was expected; a newer format is refused by its name.
Calibration read_calibration(const std::filesystem::path& path);

std::string calibration_text(const Calibration& calibration);

}  // namespace imulab
