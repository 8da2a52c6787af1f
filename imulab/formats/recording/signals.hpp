// All columns of a recording file, for imulab/inspection, before their meaning is known.
#pragma once

#include "imulab/formats/recording/format.hpp"
#include "imulab/inspection/signals.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace imulab {

/// As `most_numbers` below: no limit; and what an inspection looks at, 13 hours of seven columns at 200 Hz, in the memory that reading a day takes.
inline constexpr auto all_numbers = static_cast<std::size_t>(-1);
inline constexpr std::size_t numbers_inspected = std::size_t{1} << 26;

/// The default time for which a stream is read.
inline constexpr double stream_s = 60;

/// The columns of one table of a file. A stream (a pipe, a device, "-") is text, read once: to its end, or for `longest_s` seconds, which is reported
/// in a note. `topic`: empty takes the only table, or the only one whose columns are named like those of an IMU. Throws Error for a file of no known
/// format, and where the caller has to choose the table. Of a file with more than `most_numbers` that can be read in pieces only the
/// first third of that number is read, which a note reports.
SignalTable read_signals(const std::filesystem::path& file, const std::string& topic = "",
                         const std::vector<RecordingFormat>& formats = recording_formats(), double longest_s = stream_s,
                         std::size_t most_numbers = all_numbers);

/// Reads the columns of a text, whose lines need not all be rows of numbers: those that are not are counted in a note. `name` stands for the file.
/// `passed` is called from time to time: text that was read so far may leave memory.
SignalTable signals_of_text(
    const std::string& name, std::string_view text, const std::function<void()>& passed = [] {});

}  // namespace imulab
