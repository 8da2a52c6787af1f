// A calibration for people, in at most 80 columns.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab {

struct CalibrationResult;

/// The verdict; one line per triad with the uncertainties reached; fit and requirements; then every coefficient that the data showed, in user units,
/// with the digits that its standard uncertainty supports.
std::string calibration_summary(const Calibration& calibration);

/// All the rest: every estimated coefficient in SI and in user units, what was used, and the tests of optional terms. With the model before the
/// estimate, `coarse`: also its value and the correction.
std::string calibration_details(const Calibration& calibration, const SensorModel* coarse = nullptr);

/// Convergence curves as CSV: t (s), then for every coefficient NAME,NAME.sigma: its residual and the standard uncertainty of the residual.
std::string curves_csv(const CalibrationResult& result);

}  // namespace imulab
