// A calibration as a self-contained C99 and C++ header for firmware (docs/reference/export.md).
#pragma once

#include "imulab/calibration.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The readings of the firmware, and the contents of the header.
struct CHeaderOptions {
  /// Readings as the driver gives them. Absent: as the calibration's recording had them, or, where it does not say, the model's raw readings.
  std::optional<RecordedAs> accel{}, gyro{};
  bool fixed_point = false;  ///< also imulab_compensate_fixed and imulab_filter_fixed, in integers
  bool q15 = false;          ///< also imulab_compensate_q15, in integers of 16 bits, and imulab_filter_fixed
  /// The largest readings that the integers hold, in the readings' unit. 0: 32768 counts where that is at least 1.5 g or 50 deg/s,
  /// else 16 g and 2000 deg/s by the calibration's scale.
  double accel_range = 0, gyro_range = 0;
  /// All names begin with it and an underscore, macros with its capitals: a program with several IMUs gives each header its own.
  std::string prefix{"imulab"};
  std::string calibration_sha256{};  ///< of the calibration's file; empty: that of the calibration as imulab writes it is stated
};

/// The text of a header with `imulab_compensate`, which compensates one sample (readings as the options say -> m/s^2, rad/s), `imulab_out_of_range`,
/// which checks temperatures, `imulab_filter_push` and `imulab_filter_flush`, which reject outliers as OutlierFilter does, and `imulab_selftest`: no
/// allocation, no library; in double, or in the type that IMULAB_REAL names. Throws Error for a calibration whose numbers are not finite, for
/// readings that the calibration does not fit (a unit of its model is counts, the reading's is not), for a model that the integers cannot hold, and
/// for a prefix that cannot begin a name. Two different headers with one prefix do not compile together.
std::string c_header(const Calibration& calibration, const CHeaderOptions& options);
/// With the default options.
std::string c_header(const Calibration& calibration);
/// Uncertainties are not listed; lever arms are, if the calibration has any, with the error from leaving them out.
std::vector<std::string> left_out_of_c_header(const Calibration& calibration);

}  // namespace imulab
