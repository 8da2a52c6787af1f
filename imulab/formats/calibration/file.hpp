// Calibration files: JSON <-> Calibration (docs/formats.md), validated on reading.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Reads calibration.json or truth.json; "-" is standard input. Throws Error naming file, field and what was expected; a newer format is refused by
/// its name. Top-level keys beyond the format (a truth's rig errors) are left alone.
Calibration read_calibration(const std::filesystem::path& path);

/// Reads the text of such a file; `file` is its name in messages.
Calibration parse_calibration(std::string_view text, const std::string& file);

/// The calibration as JSON text that reads back to the same numbers. Throws Error where a coefficient is not finite.
std::string calibration_text(const Calibration& calibration);
/// Writes that text, whole or not at all. Throws Error also where the file cannot be written.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

/// Fills in the origin of the calibration, as the session declares it: the IMU's serial number, who took the data, the time now (UTC), this
/// software's version, the session's file and its SHA-256, and the form of the readings in the recordings. `recordings`: one for each of the
/// session's.
void add_declared_origin(Calibration& calibration, const Session& session, std::span<const Recording> recordings);
/// That, and each recording's file with SHA-256, size, stamps and range of thermal readings. Throws Error where a file cannot be read.
void add_provenance(Calibration& calibration, const Session& session, std::span<const Recording> recordings);

/// A file is compared with its SHA-256 at the time of the calibration.
enum class FileState { unchanged, changed, missing };
struct VerifiedFile {
  std::filesystem::path file;
  FileState state;
};
/// The session's file, where it is now, and the recordings beside it.
std::vector<VerifiedFile> verify_sources(const Calibration& calibration, const std::filesystem::path& session);

/// "imulab 0.1.0"
std::string software();

/// A simulation's truth: the calibration, and under the key "rig" each recording's rig errors by name (rad, s).
struct RecordedRigErrors {
  std::string recording;
  RigErrors errors;
};
std::string truth_text(const Calibration& calibration, const std::vector<RecordedRigErrors>& rig);

}  // namespace imulab
