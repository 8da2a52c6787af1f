// The sources of error of an inertial solution: the sensors, the start, the barometer. Every size is one sigma of a draw, or fixed.
#pragma once

#include "imulab/core/spread.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/noise.hpp"
#include "imulab/model/sensor_model.hpp"

#include <array>
#include <optional>
#include <vector>

namespace imulab {

/// Of the start, in east-north-up axes: attitude [rad] (the computed attitude is (I - [error x]) C_nb), velocity [m/s], position [m].
struct StartErrors {
  std::array<Spread, 3> attitude{}, velocity{}, position{};
  /// In place of `attitude`: that of an alignment at rest over this time [s], which the sensors' own errors cause (levels: accelerometers;
  /// heading: gyros).
  std::optional<double> aligned_over;
};

/// Height reads true height + bias + a first-order Markov process.
struct BarometerErrors {
  Spread bias{};              // m
  double noise = 0;           // m, one sigma of the process
  double time_constant = 10;  // s, of the process
};

struct ErrorSources {
  SensorModel model;                                                   // what the navigator compensates with: the ideal unit, or a calibration
  std::vector<CoefficientIndex> coefficients;                          // table indices of those with an error
  Eigen::VectorXd fixed;                                               // the error of each [SI of the table]: exactly this,
  Eigen::MatrixXd covariance;                                          // and a draw with this covariance
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();  // thermal readings less their reference, throughout
  NoiseModel gyro_noise, accel_noise;                                  // of the compensated output
  StartErrors start;
  BarometerErrors barometer;
};

/// The errors that remain after a calibration: its model and its whole covariance, without lever arms, which `compensate` does not know. The noise is
/// zero: a calibration does not state it.
ErrorSources error_sources(const Calibration& calibration);

}  // namespace imulab
