// Calibration files: JSON <-> Calibration (docs/formats.md), validated on reading.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Reads calibration.json or truth.json; "-" is standard input. Throws Error naming file, field and what was expected; a newer format is refused by
/// its name. Top-level keys beyond the format (a truth's rig errors) are left alone.
Calibration read_calibration(const std::filesystem::path& path);

/// The same from text; `file` is its name in messages.
Calibration parse_calibration(std::string_view text, const std::string& file);

/// The calibration as JSON text that reads back to the same numbers. Throws Error where a coefficient is not finite.
std::string calibration_text(const Calibration& calibration);
/// Writes that text, whole or not at all. Throws Error also where the file cannot be written.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

/// Fills in where the calibration comes from: the time now (UTC), this software's version, the session's file and the SHA-256 of its text.
void add_provenance(Calibration& calibration, const Session& session);
/// "imulab 0.1.0"
std::string software();

/// A simulation's truth: the calibration, and under the key "rig" each recording's rig errors by name (rad, s).
struct RecordedRigErrors {
  std::string recording;
  RigErrors errors;
};
std::string truth_text(const Calibration& calibration, const std::vector<RecordedRigErrors>& rig);

}  // namespace imulab
