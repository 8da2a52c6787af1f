// A rest as the sensors give it: the body's motion step by step, and its axes carried by the gyros. What both alignments start from.
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/navigation/alignment.hpp"

#include <vector>

namespace imulab {

struct RestMotion {
  std::vector<BodyStep> steps;
  std::vector<double> intervals;      // s
  double duration = 0;                // s
  Vector3d earth = Vector3d::Zero();  // its rate, east-north-up [rad/s]
  double gravity = 0;                 // m/s^2

  /// Takes a vector of n, as n is after time t, to n as it was at the start: n turns with the Earth.
  Matrix3d turned_back(double t) const { return rotation_exp(t * earth); }
};

/// With coning and sculling. Error for a place near a pole, Unsupported for a rest too short.
RestMotion rest_motion(std::span<const TimedIncrement> samples, const AlignmentSite& site);

/// Velocity that each step's force gives, in the body axes of the rest's start as the gyros carry them; and from the body's at the end to those.
struct CarriedRest {
  std::vector<Vector3d> velocity;
  Matrix3d C_0b = Matrix3d::Identity();
};
CarriedRest carried(const RestMotion& rest);

/// White noise: declared, or as the rest shows it.
struct Densities {
  double gyro, accel;
};
Densities densities(const RestMotion& rest, const AlignmentSensors& sensors);

/// Error where the forward axis is within a degree of the vertical: a heading is not defined there.
void check_has_heading(const Matrix3d& C_nb);

/// What phi (C_nb of the truth = (I + [phi x]) C_nb) adds to the heading, as a row; for an attitude that has one.
Eigen::RowVector3d heading_gradient(const Matrix3d& C_nb);

}  // namespace imulab
