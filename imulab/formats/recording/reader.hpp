// Recording files -> Recording (docs/reference/recordings.md): in memory, or on disk where it is too long.
#pragma once

#include "imulab/files.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/stored.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// As above, in one of these formats.
RecordingReading read_recording(const Session& session, const RecordingSource& source, const std::vector<RecordingFormat>& formats);

struct StoredReading {
  StoredRecording recording;
  std::vector<std::string> warnings;  ///< as those of read_recording
};

/// Reads a recording whose columns would take more than `most_bytes` in memory. Nothing where they take less, or where it cannot be read in pieces,
/// which `why` then says: another format than text, .npy and .npz, triads in several tables, increments without a declared rate. Throws Error as
/// read_recording does, and where the folder for temporary files has no room.
std::optional<StoredReading> read_stored(const Session& session, const RecordingSource& source, std::uint64_t most_bytes, std::string& why,
                                         const std::vector<RecordingFormat>& formats = recording_formats());

}  // namespace imulab
