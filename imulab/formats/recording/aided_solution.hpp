// Files of aided solutions: CSV with sigmas, GeoJSON and KML tracks, RTKLIB positions, ROS 2 odometry (docs/theory/aided.md).
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace imulab {

/// By the ending of the name: .geojson, .kml, .pos, .mcap (odometry.hpp), else CSV. The file appears whole or not at all. `gps_ahead`: GPS time less
/// the recording's stamps [ns], of which a .pos file has the dates. Throws Error where it cannot be written, and for a .pos file without them.
void write_aided_solution(const std::filesystem::path& path, const AidedNavigation& navigation, std::optional<std::int64_t> gps_ahead = {});

/// Has dates, which a recording with a clock of its own does not give.
bool needs_dates(const std::filesystem::path& path);
/// Throws Error, which says what to declare, where there are none.
void expect_dates(const std::filesystem::path& path, const std::optional<std::int64_t>& gps_ahead);

/// One that is not CSV.
bool has_aided_ending(const std::filesystem::path& path);

}  // namespace imulab
