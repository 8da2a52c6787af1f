// A calibration from a drive while it is being driven: what it has shown so far, and which manoeuvre shows the rest.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/calibration.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

/// Coefficients that a manoeuvre would show, the farthest from its requirement first.
struct MissingCoefficients {
  std::string shown_by;  ///< empty: no motion does
  std::vector<std::string> coefficients;
};

/// The state so far.
struct LiveDriveView {
  std::string imu;
  double time_s = 0;  ///< since the first sample
  std::size_t samples = 0;
  std::vector<RequirementResult> requirements;  ///< empty before the first estimate, and where there are none
  std::vector<MissingCoefficients> missing;     ///< the farthest first
  std::vector<std::string> because;             ///< of a doubtful estimate
  std::string problem;                          ///< why there is no estimate yet
  bool done = false;
};

/// What the coefficients of the requirements still lack, without requirements what is as uncertain as before the drive.
std::vector<MissingCoefficients> missing_coefficients(const Calibration& calibration, const std::vector<Requirement>& requirements);

/// Lines that begin with the time.
std::string live_drive_lines(const LiveDriveView& view);
/// On one line.
std::string live_drive_json(const LiveDriveView& view);

}  // namespace imulab
