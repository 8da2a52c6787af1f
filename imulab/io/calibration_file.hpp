// Calibration files: JSON <-> Calibration (docs/formats.md), validated on reading.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Reads calibration.json or truth.json; "-" is standard input. Throws Error naming file, field and what was expected; a newer format is refused by its name.
/// Top-level keys beyond the format (a truth's rig errors) are left alone.
Calibration read_calibration(const std::filesystem::path& path);

/// The same from text; `file` is its name in messages.
Calibration parse_calibration(std::string_view text, const std::string& file);

/// The calibration as JSON text that reads back to the same numbers.
std::string calibration_text(const Calibration& calibration);

/// A simulation's truth: the calibration, and under the key "rig" each recording's rig errors by name (rad, s).
struct RecordedRigErrors {
  std::string recording;
  RigErrors errors;
};
std::string truth_text(const Calibration& calibration, const std::vector<RecordedRigErrors>& rig);

}  // namespace imulab
