// A compensated recording as arrays for NumPy.
#pragma once

#include <filesystem>

namespace imulab {

struct CompensatedRecording;

/// Writes an .npz archive: `time_ns` [n] int64; `gyro` and `accel` [n, 3] in rad/s and m/s^2 (increments: rad and m/s); where some sample has a flag,
/// `saturated`, `out_of_range` and `replaced` [n] bool. The file appears whole or not at all. Throws Error where it cannot be written, and for more
/// than 4 GB, which an archive of this kind cannot hold.
void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& compensated);

}  // namespace imulab
