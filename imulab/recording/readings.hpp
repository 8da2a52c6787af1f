// The pieces of which recordings are made: declarations, stamps, conversions.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The declaration of a session, without the temperatures.
RecordingOptions recording_options(const RecordingSource& source);

/// Stamps [s] as whole nanoseconds. Throws Error, naming the sample, for one that is no time.
std::vector<std::int64_t> nanoseconds_of(const std::vector<double>& t, const std::string& name);

/// One column for three axes, three, or none.
Columns3 three_columns(std::vector<std::vector<double>> columns);

/// The readings alone, without stamps, gaps and checks: for pieces of a recording. `interval_s` is used for increments only.
Recording convert_readings(Columns3 gyro, Columns3 accel, RecordingOptions options);

/// Appends samples of such a piece, with their stamps, to a recording that grows.
void append(Recording& all, const Recording& piece, const Range& samples);
/// Findings that need the whole recording: the interval where none is declared, gaps, and channels that clip. `all` is that of `append` alone.
Recording completed(Recording all, const RecordingOptions& options);

}  // namespace imulab
