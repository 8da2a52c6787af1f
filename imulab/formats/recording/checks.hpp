// What is wrong or remarkable in a recording that is read: the same whether it is read as a whole or in pieces.
#pragma once

#include "imulab/formats/recording/timed_table.hpp"
#include "imulab/recording/make_recording.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/recording/unit_names.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace imulab::recording_io {

/// Declared, or the stamps' median. Throws Error where the stamps contradict what is declared.
double nominal_interval_s(std::span<const std::int64_t> time_ns, const std::string& file, const RecordingSource& source,
                          std::vector<std::string>& warnings);

/// Throws Error for a reading that no sensor gives, named by its line.
void expect_plausible(const Columns3& triad, const ReadingOptions& options, Quantity quantity, double interval_s, const TimedTable& table);
void expect_possible_temperature(const std::optional<ThermalSource>& source, const Columns3& readings, const TimedTable& table);

/// Of the gaps that the steps do not explain. `table`: for the places of rows.
void warn_of_gaps(const RecordingView& recording, const TimedTable& table, std::span<const Step> steps, std::vector<std::string>& warnings);
void warn_of_saturated(const RecordingView& recording, const TimedTable& table, std::vector<std::string>& warnings);
/// Increments become rates by the declared interval, so a wrong one scales them.
void warn_of_rate(const RecordingSource& source, const RecordingView& recording, const TimedTable& table, std::vector<std::string>& warnings);
void warn_of_repeated(const TimedTable& table, std::vector<std::string>& warnings);

}  // namespace imulab::recording_io
