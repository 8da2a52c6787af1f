// A calibration as a table.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab {

struct CalibrationResult;

/// A coefficient as people know it: offsets in ug and deg/h, scales as ppm from one or counts per unit, misalignments relative to their row's scale.
struct UserValue {
  double value, uncertainty;  ///< NaN where the coefficient was not estimated
  std::string unit;
};
UserValue user_value(const Calibration& calibration, CoefficientIndex index);

/// Every estimated coefficient with its standard uncertainty, in SI and in user units (ug, deg/h, ppm, arcsec, ...), then what the fit says of itself
/// and the verdict. With the model before the estimate, `coarse`: in user units, from what value by what correction to what value.
std::string calibration_table(const Calibration& calibration, const SensorModel* coarse = nullptr);

/// Convergence curves as CSV: t (s), then for every coefficient NAME,NAME.sigma: its residual and the standard uncertainty of the residual.
std::string curves_csv(const CalibrationResult& result);

}  // namespace imulab
