// The inverse question: how coarse a table, how late its turns, how noisy an IMU may be for a calibration to meet its requirements.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/predict.hpp"

#include <vector>

namespace imulab::turntable {

/// Throws Error where a coefficient is not among those that the calibration estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// Requirements that are not met, each by its worst coefficient, with the source of most of its variance.
std::vector<Shortfall> shortfalls(const Plan& plan, const std::vector<Requirement>& requirements);

ErrorSizes error_sizes(const Plan& plan);

/// The plan with the sigmas of angle, orthogonality and zero, or of the turns' timing, or the IMU's noise times `factor`.
Plan scaled(Plan plan, Knob knob, double factor);

/// The largest factor tried, at least 1: a table of 10 arcmin (beyond, the third order matters), turns late by 10 s, or by the time at which five
/// sigmas are a quarter of the shortest hold, noise a million times the declared.
double largest_factor(const Plan& plan, Knob knob);

/// A knob's tolerance with the others as declared.
Tolerance tolerance(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);
/// A knob's tolerance with everything else perfect: the other knobs, g and latitude.
Tolerance tolerance_alone(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);

}  // namespace imulab::turntable
