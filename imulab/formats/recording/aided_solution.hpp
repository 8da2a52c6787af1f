// Files of aided solutions: CSV with sigmas, GeoJSON and KML tracks, RTKLIB positions, ROS 2 odometry (docs/theory/aided.md).
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <filesystem>

namespace imulab {

/// By the ending of the name: .geojson, .kml, .pos, .mcap (odometry.hpp), else CSV. The dates of a .pos file are the recording's stamps as seconds
/// since 1970. The file appears whole or not at all. Throws Error where it cannot be written.
void write_aided_solution(const std::filesystem::path& path, const AidedNavigation& navigation);

/// One that is not CSV.
bool has_aided_ending(const std::filesystem::path& path);

}  // namespace imulab
