// What the methods that start from rests share: the start of the fit, and the finished calibration with its verdict.
#pragma once

#include "imulab/estimate/fit.hpp"
#include "imulab/estimate/rest.hpp"
#include "imulab/estimate/scaled_model.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/recording/session.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Rests, their noise and the accelerometers' coarse solution.
struct Start {
  std::vector<Rest> rests;
  SampleNoise noise;  ///< raw
  Scaling scaling;
  SensorModel scaled_model;
  Prior prior;        ///< what holds without the data: the declared unit; for counts the coarse solution
  std::vector<std::string> notes, warnings;
};

/// Throws Unsupported for too few or too similar rests, Error where the accelerometers' declared unit contradicts gravity.
Start start_from_rests(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, double gravity);

/// Is a coarse matrix of SI readings that of a sensor whose axes and unit are as declared?
bool near_identity(const Matrix3d& matrix);

/// The declared gyro noise density in place of the measured noise, once the start has its matrix.
void use_declared_gyro_noise(Start& start, const Recording& recording, const ImuDeclaration& imu);

/// Sets coefficients that are not to be estimated to what holds without the data. Throws Error for counts whose offsets or scales are among them.
void keep_start_of_others(Start& start, const std::vector<int>& indices, const std::vector<int>& supplied);

/// Throws Unsupported where an axis reads the same in every sample.
void expect_alive(const Columns3& triad, std::string_view file, std::string_view name, std::string_view consequence);

/// The accelerometer coefficients in the accelerometers' frame: offsets and the lower triangle of the matrix.
std::vector<int> accel_coefficients();

/// Table indices of `wanted` that `supplied` has; throws Error naming one that the method does not supply.
std::vector<int> choose_terms(const std::vector<int>& wanted, const std::vector<int>& supplied, std::string_view method);

/// Model, covariance and quality from a converged fit: raw units, g's uncertainty added, undetermined coefficients named.
Calibration finish(std::string_view method, const Start& start, Fit fit, const SensorModel& scaled_model, const std::vector<int>& indices,
                   const ImuDeclaration& imu, const Site& site);

/// A note that `what` spreads more than its sample noise explains.
std::string spread_note(std::string_view what, double spread, std::string_view unit_name);

/// The verdict: good, or doubtful for these reasons.
void conclude(Calibration& calibration, const std::vector<std::string>& doubts);

/// What is doubtful whatever the method: undetermined coefficients, few degrees of freedom, many dropped parts, residuals of the wrong size, g.
std::vector<std::string> common_doubts(const Calibration& calibration, const Site& site, std::size_t dropped, std::size_t all);
/// The same, and what is doubtful of the fit's course.
std::vector<std::string> common_doubts(const Calibration& calibration, const Fit& fit, const Site& site, std::size_t dropped, std::size_t all);

}  // namespace imulab
