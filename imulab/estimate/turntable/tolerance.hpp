// The inverse problem: the largest table errors, turn delays or IMU noise with which a calibration meets its requirements.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/predict.hpp"

#include <vector>

namespace imulab::turntable {

/// Throws Error if the calibration does not estimate a required coefficient.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// Returns requirements that are not met, each with its worst coefficient and the source of most of its variance.
std::vector<Shortfall> shortfalls(const Plan& plan, const std::vector<Requirement>& requirements);

ErrorSizes error_sizes(const Plan& plan);

/// Returns the plan with `factor` times the sigmas of angle, orthogonality and zero, or of the turns' timing, or the noise of the IMU.
Plan scaled(Plan plan, Knob knob, double factor);

/// Returns the largest factor that is tried, at least 1: a table error of 10 arcmin (beyond it, third-order terms matter), a delay of 10 s or one for
/// which five sigmas are a quarter of the shortest hold, or a million times the declared noise.
double largest_factor(const Plan& plan, Knob knob);

/// Returns a knob's tolerance with the others as declared.
Tolerance tolerance(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);
/// Returns a knob's tolerance with everything else perfect: other knobs, g and latitude.
Tolerance tolerance_alone(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);

}  // namespace imulab::turntable
