// The quality of a hybrid calibration: residuals, rejected blocks, scatter, doubts.
#pragma once

#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/kernel/findings.hpp"

namespace imulab::hybrid {

/// Returns determined and considered coefficients with the noise covariance; others stay at the coarse solution and are named.
Calibration calibration_of(const Data& data, const Iterate& iterate);

/// Fills in the quality of `calibration` and enlarges its uncertainties if the velocities scatter.
void report(const Data& data, const Converged& result, const Site& site, Calibration& calibration, kernel::Findings& findings);

/// Adds the effects that the last pass estimated, if any.
void add_effects(const Data& data, const Iterate& last, Calibration& calibration, kernel::Findings& findings);

}  // namespace imulab::hybrid
