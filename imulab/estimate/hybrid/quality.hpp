// What a hybrid calibration says of itself: residuals, what was left out, scatter, doubts.
#pragma once

#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/kernel/findings.hpp"

namespace imulab::hybrid {

inline constexpr const char* wrong_latitude = "the latitude seems to be wrong";

/// Fills in the quality of `calibration`, whose uncertainties are enlarged where the velocities scatter.
void report(const Data& data, const Converged& result, const Site& site, Calibration& calibration, kernel::Findings& findings);

/// Coefficients of which the data say nothing: cubic terms look like scales at the force and the rate that the data have, and quadratic terms of the
/// gyros, which turns in both directions tell from scales, like nothing that they can be told from. They count in the scales' covariance.
void consider_nonlinearity(const Data& data, Calibration& calibration);

}  // namespace imulab::hybrid
