// Navigation solutions and heights over time as CSV (docs/formats.md).
#pragma once

#include "imulab/navigation/integration/solution.hpp"

#include <filesystem>

namespace imulab {

struct HeightRecord;

/// A solution has the columns t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg: s, m above the ellipsoid, m/s east,
/// north and up, Euler angles of the body axes. Reads them in any order. Throws Error with file, line and column as read_recording does, and for a
/// latitude beyond 90 deg.
Solution read_solution(const std::filesystem::path& path);

/// The file appears whole or not at all; the heading is written from 0 to 360 deg. Throws Error where it cannot be written.
void write_solution(const std::filesystem::path& path, const Solution& solution);

/// Reads the columns t,height_m (s, m), as a barometer gives them. Throws Error with file, line and column.
HeightRecord read_heights(const std::filesystem::path& path);

}  // namespace imulab
