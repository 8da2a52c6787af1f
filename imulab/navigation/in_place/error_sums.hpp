// The error equations of an IMU that turns in one place, over a block of time (Cheng 2014 sec 2.2; C_nb dw is his eq 23, C_nb df his eq 22):
//
//   phi' = -w_in x phi - C_nb dw                   attitude error, C_hat = (I - [phi x]) C
//   dV'  =  (0, 0, g) x phi + C_nb df + v x C_nb dw    velocity error
//
// Where the IMU stays in one place v = 0, and the force is that of gravity. Where a hand moves it from place to place dV stands for dV - v x phi,
// which is the same where v = 0 again, and what the hand does to it is in the last term (an invariant error: Barrau 2017): the noise of a measured
// force across the attitude error would look like knowledge of the heading.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace imulab::in_place {

/// Slow noise of a triad's offsets, the same on each axis: a random walk, and flicker as a sum of independent first-order processes.
struct SlowNoise {
  static constexpr int processes = 3;
  double walk = 0;                       ///< u/sqrt(s)
  double flicker = 0;                    ///< u: standard deviation of each process
  std::array<double, processes> time{};  ///< s: their correlation times
  bool any() const { return walk > 0 || flicker > 0; }
};

/// White noise densities of the calibrated output, per axis; slow noise; the standard deviations of the velocity after a block, and of the gyros'
/// integral at any time.
struct Noise {
  Vector3d gyro, accel;  ///< rad/s/sqrt(Hz), m/s^2/sqrt(Hz)
  SlowNoise gyro_slow = {}, accel_slow = {};
  double velocity = 0;  ///< m/s
  double angle = 0;     ///< rad
};

/// With these densities, the other terms as declared, in a recording of this duration.
Noise noise_of(const Vector3d& gyro, const Vector3d& accel, const NoiseModels& declared, double duration_s);

/// Errors of attitude [rad] and velocity [m/s].
using Errors6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The sums that only some error models need.
struct OptionalSums {
  bool g_sensitivity = false, quadratic = false, lever_arm = false, delay = false;
  bool parts = false;
};

/// A step of a block that is short against the turning of the body: what the errors multiply, in body axes, and the integrals of C = C_nb.
struct ErrorStep {
  double duration;                     ///< s
  Vector3d rate, force;                ///< free of noise where they are known
  Matrix3d once, twice;                ///< of C over the step, once and twice
  std::array<Matrix3d, 3> with_force;  ///< of C f_b, for each axis of the force
  Matrix3d moved = Matrix3d::Zero();   ///< of [v x] C
  /// The rate and force of a turning body as measured, and its angular acceleration.
  struct Turning {
    Vector3d rate, force, acceleration;
  };
  std::optional<Turning> turning = {};
};

/// A part of a block in which the body turns by little: any function of rate and force is as good as constant there.
struct BlockPart {
  double duration = 0;                                         ///< s
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();  ///< integrals of what the errors multiply, body axes
  Matrix3d once = Matrix3d::Zero();                            ///< of C
  Matrix3d twice = Matrix3d::Zero();                           ///< of [(0, 0, g) x] times the former - [v x] C
  Matrix3d force_after = Matrix3d::Zero();                     ///< of [(0, 0, g) x] from its end to that of the block

  /// The errors after the block by errors of the calibrated rate and force that are constant in the part.
  Errors6 by_output(const Vector3d& rate_error, const Vector3d& force_error) const {
    const Vector3d turned = once * rate_error;
    return (Errors6() << -turned, once * force_error - twice * rate_error - force_after * turned).finished();
  }
};

/// Integrals over a block, C being C_nb.
struct BlockSums {
  double duration = 0;
  Vector3d velocity = Vector3d::Zero();                                         ///< computed, gravity included
  Matrix3d force = Matrix3d::Zero();                                            ///< of [(0, 0, g) x]
  Vector3d path = Vector3d::Zero();                                             ///< of v
  std::array<Matrix3d, 7> gyro;                                                 ///< of C b for b = 1, w, f: attitude from an error of the rate
  std::array<Matrix3d, 7> gyro_velocity;                                        ///< of [(0, 0, g) x] times the former - [v x] C b: velocity
  std::array<Matrix3d, 4> accel;                                                ///< of C b for b = 1, f
  Matrix3d quadratic = Matrix3d::Zero();                                        ///< of C f^2
  Eigen::Matrix<double, 3, 9> lever_arm = Eigen::Matrix<double, 3, 9>::Zero();  ///< of the size effect of lever arms of 1 m
  Vector3d delay = Vector3d::Zero();                                            ///< of C (w x f)
  Vector3d smear = Vector3d::Zero();                                            ///< of C (w x (w x f) - w' x f) / 2
  std::vector<BlockPart> parts;                                                 ///< in their order, after end_parts()
  Vector3d shaking = Vector3d::Zero();                                          ///< (m/s^2)^2: with the parts, variance of the force at rest

  BlockSums();

  /// `across`: [(0, 0, g) x].
  void add(const ErrorStep& step, const Matrix3d& across, const OptionalSums& optional);
  /// After the last step, where parts are wanted.
  void end_parts();

  /// The errors after the block, by those before it; by an error of a coefficient's calibrated output, of g (relative), of the latitude [rad] and of
  /// the accelerometers' time [s]. `latitude` [rad], `gravity` [m/s^2].
  Matrix6 by_errors_before(double latitude) const;
  Errors6 by_coefficient(const Coefficient& coefficient) const;
  Errors6 by_gravity(double gravity) const;
  Errors6 by_latitude(double latitude) const;
  Errors6 by_delay() const;
  Errors6 by_smear() const;  ///< by the mean square of a delay that is spread over a time [s^2]
  /// Their covariance from the noise; C_nb in the middle of the block.
  Matrix6 covariance(const Noise& noise, const Matrix3d& C_nb) const;
};

/// Attitude of the body, and its rate against n in n.
struct Attitude {
  Matrix3d C_nb;
  Vector3d rate_n = Vector3d::Zero();
};
using AttitudeAt = std::function<Attitude(double time)>;

/// The sums along a known motion, by midpoints of short steps.
BlockSums sums_of(const AttitudeAt& attitude, double begin, double end, double latitude, double gravity);

}  // namespace imulab::in_place
