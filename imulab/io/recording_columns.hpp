// Columns as they stand in a file -> a recording's readings: units, limits, one thermal reading for three axes.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab {

/// Columns in the order a session names them; of temperatures none, one or three.
struct FileColumns {
  std::vector<std::vector<double>> gyro, accel, gyro_temperature, accel_temperature;
};

/// Everything but the stamps and the gaps. `interval_s` is what increments are divided by.
Recording recording_of(const RecordingSource& source, double interval_s, FileColumns columns);

}  // namespace imulab
