// The quality of a hybrid calibration: residuals, blocks left out, scatter, doubts.
#pragma once

#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/kernel/findings.hpp"

namespace imulab::hybrid {

/// The determined and the considered coefficients of the table, with the noise's covariance; the others stay at the coarse solution and are named.
Calibration calibration_of(const Data& data, const Iterate& iterate);

/// Fills in the quality of `calibration`, whose uncertainties are enlarged where the velocities scatter.
void report(const Data& data, const Converged& result, const Site& site, Calibration& calibration, kernel::Findings& findings);

/// The effects that the last pass estimated, where there are any.
void add_effects(const Data& data, const Iterate& last, Calibration& calibration, kernel::Findings& findings);

}  // namespace imulab::hybrid
