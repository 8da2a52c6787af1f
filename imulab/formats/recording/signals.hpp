// All columns of a recording file, for imulab/inspection, before their meaning is known.
#pragma once

#include "imulab/formats/recording/format.hpp"
#include "imulab/inspection/signals.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

/// As `most_numbers` below: no limit; and what an inspection looks at, 13 hours of seven columns at 200 Hz, in the memory that reading a day takes.
inline constexpr auto all_numbers = static_cast<std::size_t>(-1);
inline constexpr std::size_t numbers_inspected = std::size_t{1} << 26;

/// The default time for which a stream is read.
inline constexpr double stream_s = 60;

/// The columns of a file's tables: those of `topics`, or without any those of the IMU (imu_tables.hpp). A stream (a pipe, a device, "-") is text,
/// read once: to its end, or for `longest_s` seconds, which is reported in a note. Throws Error for a file of no known format, and where the caller
/// has to choose a table. Of a file with more than `most_numbers` that can be read in pieces only the first third of that number is read, which a
/// note reports. Rows of several sensors that are interleaved in a text are tables, too. `layout`: what is declared of a text, "text decimal=,".
std::vector<SignalTable> read_tables(const std::filesystem::path& file, const std::vector<std::string>& topics = {},
                                     const std::vector<RecordingFormat>& formats = recording_formats(), double longest_s = stream_s,
                                     std::size_t most_numbers = all_numbers, const std::string& layout = "");

/// The topics of each IMU, for `read_tables`, of a file that has several at comparable rates; empty of another, of a stream and of text.
std::vector<std::vector<std::string>> imus_of(const std::filesystem::path& file, const std::string& layout = "");

/// Reads the columns of a text in any dialect, whose lines need not all be rows of numbers: those that are not are counted in a note. `name` stands
/// for the file.
SignalTable signals_of_text(const std::string& name, std::string_view bytes, const std::string& topic = "");

}  // namespace imulab
