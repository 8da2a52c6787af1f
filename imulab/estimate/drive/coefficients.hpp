// Converts the constants of an aided navigation to the sensor model. In the navigation, readings V in SI have the errors
//
//   w = (I + Mg) V_g + bg + G V_a,   a = (I + Ma) V_a + ba
//
// and in the model w = W0 + W1 V_g + C a with W1 = I + Mg, C = G (I + Ma)^-1, W0 = bg - C ba. Ma is lower triangular in the frame of the
// accelerometers, so a common rotation of both triads is a mounting angle, not a coefficient.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::drive {

/// Returns the coefficients that the method can estimate: offsets, matrices in the accelerometers' frame, g-sensitivity.
std::vector<CoefficientIndex> drive_coefficients();

/// Returns the sizes of the terms of an IMU of the declared grade (default mems).
kernel::PriorSizes optional_sizes(const ImuDeclaration& imu);

/// Returns the priors of the declared unit before any data; zero for coefficients that are not `chosen`.
aided::SensorPriors unit_priors(const ImuDeclaration& imu, const std::vector<CoefficientIndex>& chosen);

/// The model with covariance from the estimated constants and their joint covariance; `joint` additionally has the effects after them.
struct StatedUnit {
  Calibration calibration;
  Eigen::MatrixXd joint;
};
StatedUnit calibration_of(const AidedNavigation& navigation);

/// Returns the variance of an offset at mid-recording about that of the unit: declared bias instability, walk and ramp.
double wander(Triad triad, const Recording& recording, const ImuDeclaration& imu);

/// Adds a variance to the offsets of a triad.
void add_to_offsets(Calibration& calibration, Triad triad, double variance);

/// Sorts the estimated coefficients by the table, as in all methods.
void sort_by_table(Calibration& calibration);

}  // namespace imulab::drive
