// Compensated recordings as files: a bag of the same kind as its source, for programs that read bags; arrays of NumPy.
#pragma once

#include "imulab/recording/session.hpp"

#include <filesystem>

namespace imulab {

struct CompensatedRecording;

/// True if a file is named like a bag: .bag, .mcap or .db3.
bool is_bag_name(const std::filesystem::path& path);

/// Copies the bag of a recording with angular_velocity [rad/s] and linear_acceleration [m/s^2] of its topic replaced. All else stays byte for byte:
/// other topics, headers, covariances, orientations, times, order. The file appears whole or not at all; only a chunk of the bag is in memory. Throws
/// Error where the recording is no bag of the kind that the name says, where gyros and accelerometers are not of one topic of sensor_msgs/Imu, where
/// a message has no compensated sample, and where the bag was not closed.
void write_compensated_bag(const std::filesystem::path& path, const Session& session, const RecordingSource& source,
                           const CompensatedRecording& compensated);

/// Writes an .npz archive: `time_ns` [n] int64; `gyro` and `accel` [n, 3] in rad/s and m/s^2 (increments: rad and m/s); where some sample has a flag,
/// `saturated`, `out_of_range` and `replaced` [n] bool. The file appears whole or not at all. Throws Error where it cannot be written, and for more
/// than 4 GB, which an archive of this kind cannot hold.
void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& compensated);

}  // namespace imulab
