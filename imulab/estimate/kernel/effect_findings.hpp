// Findings about the effects of a calibration.
#pragma once

#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/findings.hpp"

#include <vector>

namespace imulab::kernel {

/// Adds the effects to a result: value and uncertainty in user units, and significance at `level` for all effects together. An effect that
/// contradicts its expected size becomes a doubt. Effects that are only assumed to have their expected size are named: larger ones would shift
/// coefficients unnoticed. The first rows of `covariance` belong to `coefficients`, if any.
void add_effects(Calibration& calibration, Findings& findings, const Effects& effects, const Eigen::MatrixXd& covariance, double level,
                 const std::vector<CoefficientIndex>& coefficients = {});

/// Adds a doubt if the data are improbable; `p_value` is that of Effects::p_value.
void doubt_improbable(Findings& findings, const Effects& effects, double p_value);

}  // namespace imulab::kernel
