// All columns of a text, for imulab/inspection: what signals.hpp reads of other formats, too.
#pragma once

#include "imulab/inspection/signals.hpp"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace imulab::recording_io {

constexpr std::size_t part_of_long = 3;  ///< of what may be read at once: inspection holds it three times
constexpr double with_inspection = 2.5;  ///< what the columns and their inspection take over the columns

/// "the first 5 rows were looked at".
std::string head_note(std::size_t rows);

/// The tables of a text file: one, or of interleaved sensors without `topic` those of an IMU. `layout`: what is declared of its dialect.
std::vector<SignalTable> tables_of_text_file(const std::filesystem::path& file, const std::string& topic, const std::string& layout,
                                             std::size_t most_numbers);
/// The same of a text in memory, and of a stream.
std::vector<SignalTable> tables_of_bytes(const std::string& name, std::string_view bytes, const std::string& topic, const std::string& layout);
std::vector<SignalTable> tables_of_stream(const std::filesystem::path& file, const std::string& topic, const std::string& layout, double longest_s);

}  // namespace imulab::recording_io
