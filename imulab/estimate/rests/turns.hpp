// Turns with declared angles: a hand turns a box from rest to rest.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab::rests {

struct DeclaredTurn {
  double start_s, end_s;  ///< [s] on the recording's clock
  RigAxis axis;
  Vector3d axis_b;  ///< nominal unit vector in body axes
  double angle;     ///< rad, signed
  double sigma;     ///< [rad], sigma of the rig's angle at each of the two rests
  bool moves_on;    ///< continues to a hold at other angles without a rest: the rotation between the rests is different
  double middle() const { return 0.5 * (start_s + end_s); }
  /// Returns the standard deviation of the turn's angle: both rests, and the second-order effect of a few degrees between true and nominal axis.
  double angle_sigma() const;
  /// Returns the tilt error [rad] of a turn that gravity does not determine: the error of its angle times the angle between its axis and up. If both
  /// are uncertain, the linear equations would determine one of them too well: a box on a table turns exactly about up.
  double tilt_sigma() const;
};

/// Returns the rotations in the recording's steps whose rig declares the sigma of its angles, or is a turntable.
std::vector<DeclaredTurn> declared_turns(const Session& session, const RecordingSource& source);

/// Returns by how much the rotation `C` (from the end of a turn to its start, relative to the Earth) exceeds the turn about its axis [rad]. `swept`,
/// the integral of the rate in body axes, determines whole turns. First order in the other components of the rotation.
double angle_beyond(const DeclaredTurn& turn, const Matrix3d& C, const Vector3d& swept);

/// Returns why the gyros contradict a turn (angle, direction or axis), allowing for scale and axis errors up to `scale`; empty if they do not.
std::string contradiction(const DeclaredTurn& turn, const Vector3d& swept, double scale);

}  // namespace imulab::rests
