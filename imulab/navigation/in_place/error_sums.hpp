// The error equations of an IMU that turns in one place, over a block of time (Cheng 2014 sec 2.2; C_nb dw is his eq 23, C_nb df his eq 22):
//
//   phi' = -w_in x phi - C_nb dw                   attitude error, C_hat = (I - [phi x]) C
//   dV'  =  (0, 0, g) x phi + C_nb df + v x C_nb dw    velocity error
//
// If the IMU stays in one place, v = 0 and the force is that of gravity. If a hand moves it, dV represents dV - v x phi, which is equal when v = 0
// again; the last term contains the motion (an invariant error: Barrau 2017). The noise of a measured force times the attitude error would otherwise
// appear as information about the heading.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace imulab::in_place {

/// Slow noise of a triad's offsets, equal on all axes: a random walk, and flicker as a sum of independent first-order processes.
struct SlowNoise {
  static constexpr int processes = 3;
  double walk = 0;                       ///< u/sqrt(s)
  double flicker = 0;                    ///< u: standard deviation of each process
  std::array<double, processes> time{};  ///< s: correlation times
  bool any() const { return walk > 0 || flicker > 0; }
};

/// Densities of white noise of the calibrated output, per axis; slow noise; standard deviations of the velocity after a block, and of the gyros'
/// integral at any time.
struct Noise {
  Vector3d gyro, accel;  ///< rad/s/sqrt(Hz), m/s^2/sqrt(Hz)
  SlowNoise gyro_slow = {}, accel_slow = {};
  double velocity = 0;  ///< m/s
  double angle = 0;     ///< rad
};

/// Returns noise with these densities and the other terms as declared, in a recording of this duration.
Noise noise_of(const Vector3d& gyro, const Vector3d& accel, const NoiseModels& declared, double duration_s);

/// Errors of attitude [rad] and velocity [m/s].
using Errors6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Sums that only some error models need.
struct OptionalSums {
  bool g_sensitivity = false, quadratic = false, lever_arm = false, delay = false;
  bool parts = false;
};

/// A step that is short compared with the body's rotation: the quantities that errors multiply, in body axes, and integrals of C = C_nb.
struct ErrorStep {
  double duration;                     ///< s
  Vector3d rate, force;                ///< noise-free if they are known
  Matrix3d once, twice;                ///< integrals of C over the step, once and twice
  std::array<Matrix3d, 3> with_force;  ///< integrals of C f_b, for each axis of the force
  Matrix3d moved = Matrix3d::Zero();   ///< integral of [v x] C
  /// The measured rate and force of a turning body, and its angular acceleration.
  struct Turning {
    Vector3d rate, force, acceleration;
  };
  std::optional<Turning> turning = {};
};

/// A part of a block in which the body turns by a small angle, so that any function of rate and force is nearly constant.
struct BlockPart {
  double duration = 0;                                         ///< s
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();  ///< integrals of the quantities that errors multiply, body axes
  Matrix3d once = Matrix3d::Zero();                            ///< integral of C
  Matrix3d twice = Matrix3d::Zero();                           ///< integral of [(0, 0, g) x] times the former - [v x] C
  Matrix3d force_after = Matrix3d::Zero();                     ///< integral of [(0, 0, g) x] from its end to that of the block

  /// Returns the errors after the block due to errors of the calibrated rate and force that are constant in the part.
  Errors6 by_output(const Vector3d& rate_error, const Vector3d& force_error) const {
    const Vector3d turned = once * rate_error;
    return (Errors6() << -turned, once * force_error - twice * rate_error - force_after * turned).finished();
  }
};

/// Integrals over a block, with C = C_nb.
struct BlockSums {
  double duration = 0;
  Vector3d velocity = Vector3d::Zero();   ///< computed, including gravity
  Matrix3d force = Matrix3d::Zero();      ///< integral of [(0, 0, g) x]
  Vector3d path = Vector3d::Zero();       ///< integral of v
  std::array<Matrix3d, 7> gyro;           ///< integrals of C b for b = 1, w, f: attitude from an error of the rate
  std::array<Matrix3d, 7> gyro_velocity;  ///< integrals of [(0, 0, g) x] times the former - [v x] C b: velocity
  std::array<Matrix3d, 4> accel;          ///< integrals of C b for b = 1, f
  Matrix3d quadratic = Matrix3d::Zero();  ///< integral of C f^2
  Eigen::Matrix<double, 3, 9> lever_arm = Eigen::Matrix<double, 3, 9>::Zero();  ///< integral of the size effect of lever arms of 1 m
  Vector3d delay = Vector3d::Zero();                                            ///< integral of C (w x f)
  Vector3d smear = Vector3d::Zero();                                            ///< integral of C (w x (w x f) - w' x f) / 2
  std::vector<BlockPart> parts;                                                 ///< in order, after end_parts()
  Vector3d shaking = Vector3d::Zero();                                          ///< (m/s^2)^2: with parts, variance of the force at rest

  BlockSums();

  /// Adds a step; `across` is [(0, 0, g) x].
  void add(const ErrorStep& step, const Matrix3d& across, const OptionalSums& optional);
  /// Ends the parts after the last step, if they are requested.
  void end_parts();

  /// Return errors after the block due to: errors before it; errors of a coefficient's calibrated output, of g (relative), of the latitude [rad] and
  /// of the accelerometers' time [s]. `latitude` is in rad, `gravity` in m/s^2.
  Matrix6 by_errors_before(double latitude) const;
  Errors6 by_coefficient(const Coefficient& coefficient) const;
  Errors6 by_gravity(double gravity) const;
  Errors6 by_latitude(double latitude) const;
  Errors6 by_delay() const;
  Errors6 by_smear() const;  ///< due to the mean square of a distributed delay [s^2]
  /// Returns their covariance due to noise; C_nb is at the middle of the block.
  Matrix6 covariance(const Noise& noise, const Matrix3d& C_nb) const;
};

/// Attitude of the body, and its rate relative to n in n.
struct Attitude {
  Matrix3d C_nb;
  Vector3d rate_n = Vector3d::Zero();
};
using AttitudeAt = std::function<Attitude(double time)>;

/// Returns the sums along a known motion, by midpoints of short steps.
BlockSums sums_of(const AttitudeAt& attitude, double begin, double end, double latitude, double gravity);

}  // namespace imulab::in_place
