// A coefficient as people know it: offsets in ug or mg and deg/h or deg/s, scales in ppm from one or in counts per unit, misalignments in arcsec.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>

namespace imulab {

struct UserValue {
  double value = 0;
  double uncertainty = 0;  ///< standard; NaN where it was not estimated
  std::string unit;        ///< the same for all coefficients of one term of a triad; empty where the readings are counts and the term has no name
};

/// Of a calibration's coefficient. Scales: ppm from one, or counts per unit; misalignments: relative to their row's scale.
UserValue user_value(const Calibration& calibration, CoefficientIndex index);

/// The coefficient in `other`, for example the start of the fit, with the calibration's unit and uncertainty.
UserValue user_value(const Calibration& calibration, CoefficientIndex index, const SensorModel& other);

}  // namespace imulab
