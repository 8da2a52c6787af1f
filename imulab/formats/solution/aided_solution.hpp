// Files of aided solutions: CSV with sigmas, GeoJSON and KML tracks, RTKLIB positions, ROS 2 odometry (docs/theory/aided.md).
#pragma once

#include "imulab/formats/solution/odometry.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/navigation/aided/aided.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace imulab {

struct SolutionText;

/// By the ending of the name: .geojson, .kml, .pos, .mcap (odometry.hpp), else CSV. Takes the states as they are reached (AidedOptions::each); the
/// file appears whole at commit(), or not at all. `gps_ahead`: GPS time less the recording's stamps [ns], of which a .pos file has the dates. Throws
/// Error where it cannot be written, and for a .pos file without them.
class AidedSolutionFile {
 public:
  explicit AidedSolutionFile(const std::filesystem::path& path, const std::optional<std::int64_t>& gps_ahead = {});
  void add(const AidedNavigation& navigation, double time, const NavigationState& state);
  void commit();

 private:
  const SolutionText* form_ = nullptr;
  double ahead_ = 0;  // s, of the dates
  std::string text_;
  std::size_t taken_ = 0;  // states
  std::optional<WholeFile> file_;
  std::optional<OdometryFile> odometry_;
};

/// Has dates, which a recording with a clock of its own does not give.
bool needs_dates(const std::filesystem::path& path);
/// Throws Error, which says what to declare, where there are none.
void expect_dates(const std::filesystem::path& path, const std::optional<std::int64_t>& gps_ahead);

/// Throws Error for a name with an ending that is none of these; without `aided`, for all but .csv. A device or a pipe may have any.
void expect_solution_ending(const std::filesystem::path& path, bool aided);

}  // namespace imulab
