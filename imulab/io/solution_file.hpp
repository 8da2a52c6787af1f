// Navigation solutions as CSV: t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg (s, m/s).
#pragma once

#include "imulab/navigation/solution.hpp"

#include <filesystem>

namespace imulab {

/// Reads a solution, the columns in any order. Throws Error with file, line and column as for recordings, and for a latitude beyond 90 deg.
Solution read_solution(const std::filesystem::path& path);

/// Whole or not at all.
void write_solution(const std::filesystem::path& path, const Solution& solution);

}  // namespace imulab
