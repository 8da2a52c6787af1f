// The error equations of an IMU that turns in one place (Cheng 2014 sec 2), over a block of time:
//
//   phi' = -w_in x phi - C_nb dw        attitude error, C_hat = (I - [phi x]) C
//   dV'  =  f_n x phi + C_nb df         velocity error; f_n = (0, 0, g), since the IMU stays in one place
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/estimate/hybrid/states.hpp"

#include <Eigen/Core>

#include <array>

namespace imulab::hybrid {

/// White noise densities of the calibrated output and random walks of its offsets, per axis; the standard deviation of the velocity after a block.
struct Noise {
  Vector3d gyro, accel;                                                  ///< rad/s/sqrt(Hz), m/s^2/sqrt(Hz)
  Vector3d gyro_walk = Vector3d::Zero(), accel_walk = Vector3d::Zero();  ///< rad/s/sqrt(s), m/s^2/sqrt(s)
  double velocity = 0;                                                   ///< m/s
};

/// Integrals over a block, C being C_nb.
struct BlockSums {
  double duration = 0;
  Vector3d velocity = Vector3d::Zero();                                         ///< computed, gravity included
  Matrix3d force = Matrix3d::Zero();                                            ///< of [f_n x]
  std::array<Matrix3d, 7> gyro;                                                 ///< of C b for b = 1, w, f: attitude from an error of the rate
  std::array<Matrix3d, 7> gyro_velocity;                                        ///< of [f_n x] times the former: velocity
  std::array<Matrix3d, 4> accel;                                                ///< of C b for b = 1, f
  Matrix3d quadratic = Matrix3d::Zero();                                        ///< of C f^2
  Eigen::Matrix<double, 3, 9> lever_arm = Eigen::Matrix<double, 3, 9>::Zero();  ///< of the size effect of lever arms of 1 m
  Vector3d delay = Vector3d::Zero();                                            ///< of C (w x f)

  BlockSums();
};

/// Errors of attitude (first three rows) and velocity after a block from all states before it.
Eigen::MatrixXd transition(const BlockSums& sums, const States& states, const Place& place);

/// Covariance that the noise gives attitude and velocity in a block; C_nb in its middle.
Eigen::Matrix<double, 6, 6> process_noise(const BlockSums& sums, const Noise& noise, const Matrix3d& C_nb);

}  // namespace imulab::hybrid
