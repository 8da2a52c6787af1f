// What the constants of an aided navigation are in the sensor model. The navigation has the errors of readings V in SI as
//
//   w = (I + Mg) V_g + bg + G V_a,   a = (I + Ma) V_a + ba
//
// and the model w = W0 + W1 V_g + C a with W1 = I + Mg, C = G (I + Ma)^-1, W0 = bg - C ba. Ma is lower triangular: the frame of the accelerometers,
// so that what turns both triads together is no coefficient but a mounting angle.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <vector>

namespace imulab::drive {

/// What the method can estimate: offsets, matrices in the accelerometers' frame, g-sensitivity.
std::vector<CoefficientIndex> drive_coefficients();

/// Sizes of the terms of an IMU of the declared grade, mems where none is declared.
kernel::PriorSizes optional_sizes(const ImuDeclaration& imu);

/// Before any data, of the unit of this declaration; zero for coefficients that are not among `chosen`.
aided::SensorPriors unit_priors(const ImuDeclaration& imu, const std::vector<CoefficientIndex>& chosen);

/// The model and its covariance: of the estimated constants, by their joint covariance; `joint` has the effects after them.
struct StatedUnit {
  Calibration calibration;
  Eigen::MatrixXd joint;
};
StatedUnit calibration_of(const AidedNavigation& navigation);

/// The variance of an offset in the middle of the recording about that of the unit: declared bias instability, walk and ramp.
double wander(Triad triad, const Recording& recording, const ImuDeclaration& imu);

/// Adds a variance to the offsets of a triad.
void add_to_offsets(Calibration& calibration, Triad triad, double variance);

/// The estimated coefficients in the order of the table, as all methods have them.
void sort_by_table(Calibration& calibration);

}  // namespace imulab::drive
