// Recording -> CSV (docs/formats.md, "Recordings").
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <filesystem>
#include <string>

namespace imulab {

struct CompensatedRecording;

/// Writes t,gx,gy,gz,ax,ay,az as CSV, and temperatures where there are any: seconds, SI or counts, increments as increments. The file appears whole
/// or not at all. Numbers read back exactly, except that an increment that is not a whole number may differ by one unit in the last place. Throws
/// Error where the file cannot be written.
void write_recording(const std::filesystem::path& path, const Recording& recording);

/// `source` as it describes the file that write_recording makes of its recording: one CSV file in SI units, or counts.
RecordingSource written_source(RecordingSource source);

/// A compensated recording as CSV: t,gx,gy,gz,ax,ay,az in s, rad/s and m/s^2 (increments: rad and m/s), without temperatures. With flags a column
/// more: saturated, out_of_range (a temperature outside the calibrated range) and replaced (an outlier), joined by "|".
std::string compensated_header(bool flags);
std::string compensated_rows(const CompensatedRecording& compensated, bool flags);
/// Both as a file that appears whole or not at all, with flags where some sample has one.
void write_compensated_rows(const std::filesystem::path& path, const CompensatedRecording& compensated);

}  // namespace imulab
