// The inverse question: how coarse a table, how late its turns, how noisy an IMU may be for a calibration to meet its requirements.
#pragma once

#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/model/requirement.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace imulab::turntable {

/// Throws Error where a coefficient is not among those that the calibration estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan);

/// Requirements that are not met, each by its worst coefficient, with the source of most of its variance.
std::vector<Shortfall> shortfalls(const Plan& plan, const std::vector<Requirement>& requirements);

/// The groups of errors that are scaled.
enum class Knob { table, timing, imu, all };
std::string_view to_string(Knob knob);

/// The scaled sizes: sigmas of the table, noise of the IMU; SI. 0: none, or known exactly.
struct ErrorSizes {
  double angle = 0, orthogonality = 0, zero = 0, timing = 0;
  double gyro_noise = 0, accel_noise = 0, gyro_turn_on = 0, accel_turn_on = 0;
};
ErrorSizes error_sizes(const Plan& plan);

/// The plan with the sigmas of angle, orthogonality and zero, or of the turns' timing, or the IMU's noise times `factor`.
Plan scaled(Plan plan, Knob knob, double factor);

/// The coarsest that meets the requirements.
struct Tolerance {
  std::optional<double> factor;       ///< times the declared size (1 arcsec, 1 ms where nothing is); absent: not even a perfect one meets them
  bool unlimited = false;             ///< the factor is the largest that was tried (`largest_factor`)
  ErrorSizes sizes;                   ///< at this factor
  std::vector<Shortfall> shortfalls;  ///< where none meets them: with a perfect one
};

/// The largest factor tried, at least 1: a table of 10 arcmin (beyond, the third order matters), turns late by 10 s, or by the time at which five
/// sigmas are a quarter of the shortest hold, noise a million times the declared.
double largest_factor(const Plan& plan, Knob knob);

/// A knob's tolerance with the others as declared.
Tolerance tolerance(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);
/// A knob's tolerance with everything else perfect: the other knobs, g and latitude.
Tolerance tolerance_alone(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements);

}  // namespace imulab::turntable
