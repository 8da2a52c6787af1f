// The pieces of which recordings are made: declarations, stamps, conversions.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The declaration of a session, without the temperatures.
RecordingOptions recording_options(const RecordingSource& source);

/// One column for three axes, three, or none.
Columns3 three_columns(std::vector<std::vector<double>> columns);

/// The readings alone, without stamps, gaps and checks of readings: for pieces of a recording. `interval_s` is used for increments only. Throws Error
/// for options out of range.
Recording convert_readings(Columns3 gyro, Columns3 accel, RecordingOptions options);

/// Appends samples of such a piece, with their stamps, to a recording that grows. Throws Error for a range beyond the piece.
void append(Recording& all, const Recording& piece, const Range& samples);
/// Findings that need the whole recording: the interval where none is declared, gaps, and channels that clip. `all` is that of `append` alone.
Recording completed(Recording all, const RecordingOptions& options);

}  // namespace imulab
