// What a result says of its effects.
#pragma once

#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/findings.hpp"

#include <vector>

namespace imulab::kernel {

/// Adds the effects to a result: each with value and uncertainty [user units], and whether it is significant among all at `level`; what contradicts
/// its expected size, as a doubt; and which are assumed to be as small as expected: larger ones would not show, though they shift coefficients.
/// The first rows of the covariance are those of `coefficients`, where it has any.
void add_effects(Calibration& calibration, Findings& findings, const Effects& effects, const Eigen::MatrixXd& covariance, double level,
                 const std::vector<CoefficientIndex>& coefficients = {});

/// Doubts data that Effects::p_value finds improbable.
void doubt_improbable(Findings& findings, const Effects& effects, double p_value);

}  // namespace imulab::kernel
