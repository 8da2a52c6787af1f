// Verification that the files of a calibration are still those that it was made from. Shared by the command and the Python module.
#pragma once

#include "imulab/formats/calibration/file.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

struct VerifiedCalibration {
  std::string name;                 ///< of its file
  std::vector<VerifiedFile> files;  ///< the session's, then the recordings
};

/// The session's file of a calibration: as `given` (a folder or a file), else where the calibration names it, from here or from the calibration's
/// folder, else beside the calibration; the recorded name where none of these is a file.
std::filesystem::path find_session(const std::string& given, const std::string& calibration_file, const std::string& recorded);

/// Compares the files with the calibration's hashes. `session`: its folder or file, if it is not where it was. Throws Error as read_calibration does,
/// and where there are no hashes.
VerifiedCalibration verify(const std::string& calibration_file, const std::string& session = "");

std::string verification_json(const VerifiedCalibration& verified);
std::string verification_text(const VerifiedCalibration& verified);
/// Which files were changed or are missing. Empty: all are unchanged.
std::string shortcomings(const VerifiedCalibration& verified);

}  // namespace imulab
