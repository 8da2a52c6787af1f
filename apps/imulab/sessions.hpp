// Sessions, recordings and calibrations as verbs take them: a recording in place of a session is inspected first.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab::command {

/// What the command line says of recordings without a session: --set and --topic.
struct RecordingWords {
  std::vector<std::string> declarations, topics = {};
};

/// True for a session, which needs none of these words; and for a file that is not there.
bool declares_itself(const std::string& path);

/// What a recording is opened for: noise has no use for axes, gravity and turns, so nothing is said or asked about them.
enum class Purpose { calibration, noise, compensation };

/// The session of that name; a recording, which may be a folder, is inspected, and what is assumed goes to standard error: a line, or with --verbose
/// the evidence. Throws Unsupported, with what has to be declared, where the data leave something open. `most_numbers`: as InspectionTask has it.
Session open_session(const std::filesystem::path& path, const RecordingWords& words, std::size_t most_numbers = numbers_inspected,
                     Purpose purpose = Purpose::calibration);

/// Whether the evidence of inspections is printed, from here on.
void show_evidence(bool shown);

/// Sessions and recordings of one unit as one session, whose file is the first's: each as `open_session`. Throws Error where one declares another
/// IMU, place or rig than the first, or has its recordings, too.
Session open_sessions(const std::vector<std::string>& paths, const RecordingWords& words);

/// The recording of that file; the only one if no name is given. Otherwise throws Error that lists them.
const RecordingSource& named_recording(const Session& session, const std::string& name);

/// Reads a session's recording for a calibration; prints the warnings of reading. Throws Error where a temperature is in another unit than in the
/// calibration.
Recording read_for(const Calibration& calibration, const Session& session, const RecordingSource& source);

struct UsableCalibration {
  Calibration calibration;
  std::vector<std::string> warnings;  ///< about it, which are printed
};
/// Reads a calibration that may be applied, and prints the warnings about it. Throws as expect_usable.
UsableCalibration read_usable(const std::string& file, bool allow_undetermined, const std::string& allow = "--allow-undetermined");

}  // namespace imulab::command
