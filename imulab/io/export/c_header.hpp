// A calibration as a self-contained C99 and C++ header for firmware (docs/export.md).
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>
#include <vector>

namespace imulab {

/// The text of a header with `imulab_compensate`, which compensates one sample (raw readings in the calibration's units -> m/s^2, rad/s),
/// `imulab_out_of_range`, which checks temperatures, and `imulab_filter_push`, which rejects outliers as OutlierFilter does: no allocation, no
/// library; in double, or in the type that IMULAB_REAL names. Throws Error for a calibration whose numbers are not finite.
std::string c_header(const Calibration& calibration);
/// The lever arms, where the calibration has any.
std::vector<std::string> left_out_of_c_header(const Calibration& calibration);

}  // namespace imulab
