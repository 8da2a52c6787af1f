// The motion of a body at rest, step by step, and its axes propagated by the gyros: the input of both alignments.
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
  Vector3d earth = Vector3d::Zero();  // rotation rate of the Earth, east-north-up [rad/s]
  double gravity = 0;                 // m/s^2

  /// Returns the rotation from n at time t to n at the start, because n turns with the Earth.
  Matrix3d turned_back(double t) const { return rotation_exp(t * earth); }
};

/// Computes the motion with coning and sculling. Throws Error near a pole, and Unsupported if the rest is too short.
RestMotion rest_motion(std::span<const TimedIncrement> samples, const AlignmentSite& site);

/// The velocity change [m/s] of each step in the body axes at the start of the rest, propagated by the gyros; and the rotation from the body axes at
/// the end to those at the start.
struct CarriedRest {
  std::vector<Vector3d> velocity;
  Matrix3d C_0b = Matrix3d::Identity();
};
CarriedRest carried(const RestMotion& rest);

/// White noise densities, rad/s/sqrt(Hz) and m/s^2/sqrt(Hz), declared or estimated from the rest.
struct Densities {
  double gyro, accel;
};
Densities densities(const RestMotion& rest, const AlignmentSensors& sensors);

/// Throws Error if the forward axis is within 1 deg of the vertical, where the heading is undefined.
void check_has_heading(const Matrix3d& C_nb);

/// Returns the derivative of the heading by phi (C_nb_true = (I + [phi x]) C_nb) as a row, for an attitude with a defined heading.
Eigen::RowVector3d heading_gradient(const Matrix3d& C_nb);

}  // namespace imulab::alignment
