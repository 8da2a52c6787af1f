// Calibrations compared on the road: position errors of many drives, as a picture and as a page.
#pragma once

#include <string>
#include <vector>

namespace imulab {

/// The drives of one IMU navigated with one calibration.
struct DrivenCalibration {
  std::string name;                         ///< "classical"
  std::string claim;                        ///< "gyro misalignments known to 74 arcsec"
  std::vector<std::vector<double>> errors;  ///< horizontal position error of each drive at each of the times [m]
  std::vector<double> largest;              ///< of each drive's errors [m], sorted
};

struct DrivesReport {
  std::string title, story;  ///< the story in sentences
  std::vector<double> time;  ///< s
  std::vector<DrivenCalibration> calibrations;
  std::vector<std::string> next;  ///< what the reader may do
};

/// SVG: each drive as a thin line, the median of each calibration as a thick one.
std::string drives_picture(const DrivesReport& report);
/// HTML, self-contained.
std::string drives_page(const DrivesReport& report);

}  // namespace imulab
