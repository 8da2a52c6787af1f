// Sets up the problem of an aided navigation: priors, noise and nuisances of an IMU and its aids.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/grade.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/recording.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab::aided {

/// Standard deviations of the sensors' errors after calibration, before any aid.
struct SensorPriors {
  Vector3d gyro_offset, accel_offset;          // rad/s, m/s^2
  Matrix3d gyro_matrix, accel_matrix;          // (row, column) of the calibrated output
  Matrix3d g_sensitivity;                      // (rad/s)/(m/s^2)
  double gyro_walk = 0, accel_walk = 0;        // random walk of the offsets [unit/sqrt(s)]
  double gyro_flicker = 0, accel_flicker = 0;  // bias instability B, if it is modeled separately
  Vector3d gyro_noise, accel_noise;            // densities
  Eigen::MatrixXd covariance = {};  // covariance of offsets, matrices and g-sensitivity in a calibration, in the order of the states; empty: none
};
/// Sets the sensors' constants from the covariance of the coefficients [SI, for the model's raw readings], converted to the calibrated output.
/// Constants without a coefficient become zero; noise and walks do not change.
void take_coefficients(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Eigen::MatrixXd& covariance,
                       SensorPriors& priors);
/// Returns the random walk of an offset that represents a sensor's slow noise [unit/sqrt(s)], if its size is estimated from the data.
double offset_walk(const NoiseModel& noise);
/// Sets white noise, walk and flicker; the slow part of the flicker is added to the offsets.
void take_noise(const NoiseModel& gyro, const NoiseModel& accel, SensorPriors& priors);
/// Returns the priors from the calibration's uncertainties, if it has some for a triad's matrix, and the turn-on of the grade; otherwise from the
/// grade (default mems). Noise is as declared, or measured in the rests, or from the grade.
SensorPriors sensor_priors(const Calibration& calibration, const ImuDeclaration& imu);

struct SetupOptions {
  bool matrices = true;                              // scales, misalignments and g-sensitivity are states under their priors
  double gyro_delay_sigma = 0.01;                    // s: triads with other filters, or stamps of their own; 0: no state
  double vehicle_interval = 1, rest_interval = 0.5;  // s: between two rows of a constraint; motion on springs decorrelates within this time
  std::vector<Outage> outages = {};                  // for all aids with a file, in addition to the aids' own outages
};

/// Makes the problem. It refers to `recording` (compensated, SI). Observations outside its time are left out. Throws Error if no aid has any.
Problem make_problem(const Recording& recording, const SensorPriors& priors, const std::vector<Aid>& aids, const Session& session,
                     const SetupOptions& options = {});

/// Adds the aid `zero_velocity` for a rest at the start of the recording that is longer than the first search for a heading, unless this aid exists
/// or another aid measures motion then. Otherwise the heading would be free until the drive begins.
void add_first_rest(Problem& problem, const Recording& recording, const Session& session);

/// The prior of all states before any data: zero or declared values with the spreads of sensors and aids.
struct Prior {
  Eigen::VectorXd mean, sigma;
};
Prior prior_of(const Problem& problem);

/// Sets the noise of the problem's sources from `out`.
void use_factors(const AidedNavigation& out, Problem& problem);

/// Adds the smoothed constants at mid-recording, with their covariance and their standard deviations before the data.
void add_constants(const Problem& problem, const SmootherPass& smoothed, AidedNavigation& out);

/// Adds the constants and the constants of `terms`, by one more pass about a trajectory with the noise of `out`.
void add_constants_with(const OutputTerms& terms, Problem& problem, FilterStart start, AboutTrajectory& trajectory, AidedNavigation& out);

/// Explains why the heading at the end is unknown; empty if it is known.
void judge_heading(AidedNavigation& navigation);

/// Navigates a recording in SI with these priors of the sensors' errors; `terms` adds constants. Throws Error like navigate_aided.
AidedNavigation navigate_under(const SensorPriors& priors, const Session& session, const Recording& recording, const std::vector<Aid>& aids,
                               const AidedOptions& options, const OutputTerms* terms = nullptr);

}  // namespace imulab::aided
