// The motion of a body at rest, step by step, and its axes carried by the gyros: the input of both alignments.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/increment.hpp"

#include <vector>

namespace imulab::alignment {

struct RestMotion {
  std::vector<integration::BodyStep> steps;
  std::vector<double> intervals;      // s
  double duration = 0;                // s
  Vector3d earth = Vector3d::Zero();  // its rate, east-north-up [rad/s]
  double gravity = 0;                 // m/s^2

  /// Takes a vector from n as it is after time t to n as it was at the start: n turns with the Earth.
  Matrix3d turned_back(double t) const { return rotation_exp(t * earth); }
};

/// With coning and sculling. Throws Error for a place near a pole, Unsupported for a rest that is too short.
RestMotion rest_motion(std::span<const TimedIncrement> samples, const AlignmentSite& site);

/// The velocity change [m/s] of each step in the body axes of the rest's start, as the gyros carry them; and the rotation to those from the body axes
/// at the end.
struct CarriedRest {
  std::vector<Vector3d> velocity;
  Matrix3d C_0b = Matrix3d::Identity();
};
CarriedRest carried(const RestMotion& rest);

/// White noise: rad/s/sqrt(Hz), m/s^2/sqrt(Hz); declared, or estimated from the rest.
struct Densities {
  double gyro, accel;
};
Densities densities(const RestMotion& rest, const AlignmentSensors& sensors);

/// Throws Error where the forward axis is within a degree of the vertical: a heading is not defined there.
void check_has_heading(const Matrix3d& C_nb);

/// Derivative of the heading by phi (C_nb of the truth = (I + [phi x]) C_nb), as a row; for an attitude that has a heading.
Eigen::RowVector3d heading_gradient(const Matrix3d& C_nb);

}  // namespace imulab::alignment
