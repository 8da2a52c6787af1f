// Turns whose angle is declared: a hand turns a box from rest to rest, and says by how much.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab::rests {

struct DeclaredTurn {
  double start_s, end_s;  ///< of the recording's clock
  RigAxis axis;
  Vector3d axis_b;  ///< nominal, unit vector in body axes
  double angle;     ///< rad, signed
  double sigma;     ///< rad: of the rig's angle at each of the two rests
  bool moves_on;    ///< to a hold at other angles, without a rest: the rotation between the rests is another one
  double middle() const { return 0.5 * (start_s + end_s); }
  /// Standard deviation of the turn's angle: both rests, and what a few degrees between the true and the nominal axis do, of second order.
  double angle_sigma() const;
  /// The angle that gravity does not determine of a turn, rad: an error of its angle tilts by its product with the angle between its axis and up.
  /// Where both are uncertain the linear equations would know one of them too well: a box on a table turns about up exactly.
  double tilt_sigma() const;
};

/// The rotations among the recording's steps whose rig declares the sigma of its angles, or is a turntable.
std::vector<DeclaredTurn> declared_turns(const Session& session, const RecordingSource& source);

/// By how much the rotation `C` (from the end of a turn to its begin, against the Earth) exceeds the turn, about the turn's axis, rad. `swept`: the
/// integral of the rate in body axes, which tells whole turns apart. First order in the rotation's other components.
double angle_beyond(const DeclaredTurn& turn, const Matrix3d& C, const Vector3d& swept);

/// Why the gyros contradict a turn: another angle, direction or axis; empty where they do not, with scales and axes off by up to the part `scale`.
std::string contradiction(const DeclaredTurn& turn, const Vector3d& swept, double scale);

}  // namespace imulab::rests
