// A calibration as a self-contained C99 and C++ header: what firmware compiles in.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab {

/// The text of a header with `imulab_compensate`, which does what compensate does to one sample, `imulab_out_of_range` of temperatures, and
/// `imulab_filter_push`, which does what OutlierFilter does: no allocation, no library; in double, or in what IMULAB_REAL names. Throws Error for a
/// calibration whose numbers are not finite.
std::string c_header(const Calibration& calibration);

}  // namespace imulab
