// The files of one recording: a triad may have one of its own, whose rows are matched by time to the gyro's rows.
#pragma once

#include "imulab/formats/recording/format.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab::recording_io {

/// Some columns of one of the tables.
struct PartColumns {
  std::size_t table = 0;
  std::vector<std::size_t> columns;
  std::vector<std::size_t> terms;  ///< of each reading: of how many of the columns it is the sum
};

/// The columns that are read of one table.
struct PartRequest {
  std::string file, topic;
  TimeSource time;
  std::vector<Column> columns;
};

struct RecordingParts {
  std::vector<PartRequest> requests;  ///< one a table
  std::vector<TableRows> tables;      ///< as they were read, or a piece of the only one
  PartColumns gyro, accel, gyro_temperature, accel_temperature;

  TableRows& reference() { return tables[gyro.table]; }
};

/// The tables of a recording, not yet read. A triad that the source does not have has no columns.
RecordingParts requested_parts(const RecordingSource& source);

/// Brings tables of another rate, or stamped at other instants, to the gyro's stamps: accelerometers as means over the gyro's intervals (said in a
/// warning; true where they are), temperatures on straight lines. Throws Error where a table has no time in common with the gyro's.
bool join_by_time(RecordingParts& parts, double interval_s, bool accel_increment, std::vector<std::string>& warnings);

/// Keeps the gyro's rows that have a partner in every other table: mutually nearest stamps at most half an interval apart. The others are
/// dropped with a warning. Throws Error where nothing matches.
void match_rows(RecordingParts& parts, double interval_s, std::vector<std::string>& warnings);

/// The places of the table's rows without those of samples that are left out.
void leave_out_lines(TableRows& table, std::size_t rows, const std::vector<std::size_t>& left_out);

/// The readings as they are in the tables, which lose them, and how they are declared.
struct Readings {
  Columns3 gyro, accel;
  RecordingOptions options;  ///< with the temperatures
};
Readings take_readings(RecordingParts& parts, const RecordingSource& source);

}  // namespace imulab::recording_io
