// The problem of an aided navigation: priors, noise and nuisances of an IMU and its aids.
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
  Matrix3d gyro_matrix, accel_matrix;          // (row, column): of the calibrated output
  Matrix3d g_sensitivity;                      // (rad/s)/(m/s^2)
  double gyro_walk = 0, accel_walk = 0;        // of the offsets [unit/sqrt(s)]
  double gyro_flicker = 0, accel_flicker = 0;  // bias instability B, where it has its own law
  Vector3d gyro_noise, accel_noise;            // densities
  Eigen::MatrixXd covariance = {};  // of offsets, matrices and g-sensitivity as a calibration has it, in the order of the states; empty: none
};
/// The sensors' constants: what the coefficients' covariance [SI, of the model's raw readings] makes of the calibrated output. Zero for what is not
/// among the coefficients; noise and walks stay.
void take_coefficients(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Eigen::MatrixXd& covariance,
                       SensorPriors& priors);
/// The random walk of an offset that stands for a sensor's slow noise [unit/sqrt(s)], where its size is found from the data.
double offset_walk(const NoiseModel& noise);
/// Takes white noise, walk and flicker, and what is slow of it into the offsets.
void take_noise(const NoiseModel& gyro, const NoiseModel& accel, SensorPriors& priors);
/// From the calibration's uncertainties, where it has some of a triad's matrix, and the grade's turn-on; else from the grade, mems where none is
/// declared. The noise is declared, or that of the rests, or the grade's.
SensorPriors sensor_priors(const Calibration& calibration, const ImuDeclaration& imu);

struct SetupOptions {
  bool matrices = true;                              // scales, misalignments and g-sensitivity as states under their priors
  double vehicle_interval = 1, rest_interval = 0.5;  // s: between two rows of a constraint; a body on springs forgets within one
  std::vector<Outage> outages = {};                  // of all aids with a file, besides the aids' own
};

/// `recording`: compensated, in SI; the problem refers to it. Observations outside its time are left out. Throws Error where no aid has any.
Problem make_problem(const Recording& recording, const SensorPriors& priors, const std::vector<Aid>& aids, const Session& session,
                     const SetupOptions& options = {});

/// A rest at the recording's begin, longer than the first look for a heading: the aid `zero_velocity` for it alone, unless there is one or another
/// aid measures motion. Without it nothing holds the heading until the drive begins.
void add_first_rest(Problem& problem, const Recording& recording, const Session& session);

/// The prior of all states before any data, about zero (or the declared values) with the sensors' and the aids' spreads.
struct Prior {
  Eigen::VectorXd mean, sigma;
};
Prior prior_of(const Problem& problem);

/// Gives the problem's sources the noise that `out` states.
void use_factors(const AidedNavigation& out, Problem& problem);

/// The constants as the smoother has them in the middle of the time, with their covariance and their standard deviations before the data.
void add_constants(const Problem& problem, const SmootherPass& smoothed, AidedNavigation& out);

/// The constants and those of `terms` beside them, by one more pass about a trajectory with the noise that `out` states.
void add_constants_with(const OutputTerms& terms, Problem& problem, FilterStart start, AboutTrajectory& trajectory, AidedNavigation& out);

/// Why the heading at the end is not known; empty: it is.
void judge_heading(AidedNavigation& navigation);

/// The navigation of a recording in SI whose sensors' errors have these priors; `terms`, where given, are constants beside them. Throws Error as
/// navigate_aided does.
AidedNavigation navigate_under(const SensorPriors& priors, const Session& session, const Recording& recording, const std::vector<Aid>& aids,
                               const AidedOptions& options, const OutputTerms* terms = nullptr);

}  // namespace imulab::aided
