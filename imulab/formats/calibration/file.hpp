// The origin of a calibration: this software, files that are verified, and a simulation's truth.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

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
