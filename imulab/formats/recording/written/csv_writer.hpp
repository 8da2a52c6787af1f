// Compensated recordings as rows of CSV (docs/reference/recordings.md).
#pragma once

#include "imulab/files.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <string>

namespace imulab {

struct CompensatedRecording;

/// `source` as it describes the file that write_recording makes of its recording: one CSV file in SI units, or counts.
RecordingSource written_source(RecordingSource source);

/// A compensated recording as CSV: t,gx,gy,gz,ax,ay,az in s, rad/s and m/s^2 (increments: rad and m/s), without temperatures. With flags a column
/// more: saturated, out_of_range (a temperature outside the calibrated range) and replaced (an outlier), joined by "|".
std::string compensated_header(bool flags);
std::string compensated_rows(const CompensatedRecording& compensated, bool flags);

}  // namespace imulab
