// The origin of a calibration: this software, files that are verified, and a simulation's truth.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Adds the declared origin (recording/origin.hpp), and each recording's file with SHA-256, size, stamps and range of thermal readings. Throws Error
/// where a file cannot be read, and for another number of recordings than the session declares, or one without samples.
void add_provenance(Calibration& calibration, const Session& session, std::span<const Recording> recordings);

/// A file is compared with its SHA-256 at the time of the calibration.
enum class FileState { unchanged, changed, missing };
struct VerifiedFile {
  std::filesystem::path file;
  FileState state;
};
/// The session's file, where it is now, and the recordings beside it.
std::vector<VerifiedFile> verify_sources(const Calibration& calibration, const std::filesystem::path& session);

/// A simulation's truth: the calibration, and under the key "rig" each recording's rig errors by name (rad, s).
struct RecordedRigErrors {
  std::string recording;
  RigErrors errors;
};
std::string truth_text(const Calibration& calibration, const std::vector<RecordedRigErrors>& rig);

}  // namespace imulab
