// A procedure's steps -> the axes' angles as functions of time: pieces in which each angle is a polynomial of time; and the turntable, which turns
// angles into the motion of the body.
//
//   const RigMotion motion = rig_motion(session.steps);
//   const BodyState body = body_state(motion, 12.5);              // s
//   sensed_motion(body, {.rate_ie_n = earth_rate_enu(0.8), .gravity = 9.81}).rate   // rad/s, of an ideal IMU
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/eigen.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace imulab {

// Three-axis turntable: axis angles -> attitude, rate and angular acceleration of the body, and what an IMU on it senses, in closed form.
// At zero angles the body frame is east-north-up; the outer axis points up, the middle axis north, the inner axis east.

/// Directions of the axes in n at zero angles, by RigAxis; unit vectors, right-handed senses of rotation.
using RigAxes = std::array<Vector3d, 3>;
/// Up, north, east.
RigAxes ideal_axes();

struct AxisState {
  double angle = 0, rate = 0, acceleration = 0;  ///< rad, rad/s, rad/s^2
};
using AxisStates = std::array<AxisState, 3>;  ///< by RigAxis

/// Motion of the body against n, in body axes.
struct BodyState {
  Matrix3d C_nb;
  Vector3d rate_nb_b;                  ///< rad/s
  Vector3d angular_acceleration_nb_b;  ///< rad/s^2
};

/// C_nb = C_nt R(l_outer, outer) R(l_middle, middle) R(l_inner, inner), and its derivatives; C_nt: how the table stands against n.
BodyState turntable_state(const RigAxes& axes, const AxisStates& states, const Matrix3d& C_nt = Matrix3d::Identity());

/// The surroundings of an IMU at a fixed place besides the rig: Earth rate and gravity, and where its accelerometers sit.
struct Surroundings {
  Vector3d rate_ie_n = Vector3d::Zero();  ///< rad/s
  double gravity = 0;                     ///< m/s^2
  Matrix3d lever_arm = Matrix3d::Zero();  ///< row i: accelerometer i from the axes' intersection, m
};

/// Angular rate against inertial space, and specific force with the size effect of each accelerometer's lever arm.
Motion sensed_motion(const BodyState& body, const Surroundings& surroundings);

/// Angle [rad] as a polynomial in u = (t - begin) / (end - begin), lowest power first.
using AnglePolynomial = std::array<double, 6>;

struct MotionPiece {
  double begin = 0, end = 0;               ///< s of the recording's clock
  std::array<AnglePolynomial, 3> angle{};  ///< by RigAxis
  std::optional<double> temperature;       ///< set point of the step, degC
  Matrix3d C_tb = Matrix3d::Identity();    ///< mount of the IMU: body axes in the table's at zero angles
  Matrix3d arm = Matrix3d::Zero();  ///< row i: accelerometer i from the axes' intersection, m, in body axes, in addition to the IMU's own lever arms
  bool at_rest() const;
};

/// The rig's motion without gaps from 0 to the end of the last step.
struct RigMotion {
  RigAxes axes = ideal_axes();
  Matrix3d C_nt = Matrix3d::Identity();  ///< attitude of the table in n
  std::vector<MotionPiece> pieces;
  double rate_before = 0;  ///< of the outer axis before the first piece, rad/s
  double end() const { return pieces.back().end; }
};

/// The motion of these steps (of one recording):
/// - hold: at rest; where its angles differ from those before, all axes move together by 10 u^3 - 15 u^4 + 6 u^5 in the gap before it, each by
///   the difference less its whole turns;
/// - rotate: a trapezoid of rate. With an acceleration it starts at once and waits at its end; without, its ramps fill the step's time:
///   |angle| = rate (T - t_ramp), zero when T = |angle| / rate.
/// The rig begins at zero angles, or at those of a hold that begins at time 0. Errors of the rig change angles, axes and the duration of rotations;
/// a step that is delayed by a late one begins as soon as that is done. Throws Error where a step does not fit into its time.
RigMotion rig_motion(std::span<const Step> steps, const RigErrors& errors = {});

/// The axes at time t [s] of a piece.
AxisStates axis_states(const MotionPiece& piece, double t);

/// The body at time t [s] of a piece.
BodyState body_state(const RigMotion& motion, const MotionPiece& piece, double t);

/// The body at time t [s]; at a joint of two pieces, the later one.
BodyState body_state(const RigMotion& motion, double t);

}  // namespace imulab
