// Recording files: CSV and plain text -> Recording, and back.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

struct RecordingReading {
  Recording recording;
  std::vector<std::string> warnings;  ///< what was met and what it means: gaps, saturated samples, dropped rows
};

/// Reads one recording of a session. Throws Error with file, line and column for text in a number, NaN, infinity, ragged rows, time running
/// backwards, missing columns, an empty file, and a declared rate that the stamps contradict.
RecordingReading read_recording(const Session& session, const RecordingSource& source);

/// Writes t,gx,gy,gz,ax,ay,az (and temperatures where there are any, and a flags column where `flags` has one text a sample), increments as
/// increments, whole or not at all. Values print so that they read back exactly; an increment that is no whole number may differ by one unit in
/// the last place.
void write_recording(const std::filesystem::path& path, const Recording& recording, const std::vector<std::string>& flags = {});

}  // namespace imulab
