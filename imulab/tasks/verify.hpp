// Checks that the files of a calibration are still those that it was made from.
#pragma once

#include "imulab/formats/calibration/file.hpp"
#include "imulab/tasks/verb.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

struct VerifyOptions : ShowOptions {
  std::string calibration, session_at;
};
/// The verb `verify`, which sets these.
Verb& declare(Verb& command, VerifyOptions& o);

/// The session's file of a calibration: as `given` (a folder or a file), else where the calibration names it, from here or from the calibration's
/// folder, else beside the calibration; the recorded name where none of these is a file.
std::filesystem::path find_session(const std::string& given, const std::string& calibration_file, const std::string& recorded);

/// Compares the files, the session's first, with the calibration's hashes. Throws Error as read_calibration does, and where there are no hashes.
AnswerOf<std::vector<VerifiedFile>> verify(const VerifyOptions& o);

}  // namespace imulab
