// The tables of a file that hold an IMU's readings, by their names and by the readings that are not zero.
#pragma once

#include "imulab/formats/recording/format.hpp"
#include "imulab/inspection/signals.hpp"

#include <string>
#include <vector>

namespace imulab::recording_io {

struct ImuTables {
  std::vector<std::string> names;  ///< one, or the gyros' and then the accelerometers'
  std::vector<std::string> notes;  ///< which tables were not taken, and why
};

/// The only table; or that whose columns are named like those of gyros and accelerometers and are not all zero; or one of gyros and one of
/// accelerometers. Of several, that with far the most rows: autopilots log averages and states of theirs beside the readings, seldom. Throws Error
/// where the caller has to choose.
ImuTables imu_tables(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables);

/// The tables of each IMU, as `names` above, of a file that has several of one kind at comparable rates; else nothing. Two tables of one sensor each
/// belong together where their names differ in the sensor alone: "sensor_gyro.1", "sensor_accel.1".
std::vector<std::vector<std::string>> all_imus(const RecordingFormat& format, const TableRequest& request,
                                               const std::vector<TableDescription>& tables);

/// A column's name; with its table's where only that one says which sensor it is: "sensor_gyro.x".
std::string name_in_table(const std::string& table, const std::string& column);

/// Takes the columns of a sensor whose three axes are zero in every row out of a table that has another sensor, which a note reports: drivers of
/// cameras give gyros and accelerometers topics of their own, with zeros for the other one.
void leave_out_zeros(SignalTable& table);

}  // namespace imulab::recording_io
