// The point of the body that an aid observes: its velocity and acceleration with their derivatives, the parts of the laws of all kinds.
#pragma once

#include "imulab/navigation/aided/observation.hpp"

namespace imulab::aided {

/// A vector with its derivatives by all states.
struct Derived {
  Vector3d value;
  Eigen::MatrixXd derivative;
};

/// Returns rows of zeros.
ObservedRows rows_of(Eigen::Index count, Eigen::Index size);
ObservedRows joined_rows(ObservedRows a, const ObservedRows& b);

/// Returns the time from the epoch to the moment of the measurement.
double offset_in_time(const Problem& problem, const Channel& channel, const Observation& observation, const Instant& at);
/// Sets the derivative by the delay of a measured quantity that changes at `rate`.
void set_delay(const Problem& problem, const Channel& channel, const Observation& observation, const Eigen::VectorXd& rate,
               Eigen::MatrixXd& derivative);

/// Returns the lever arm, zero for an aid without one.
Vector3d lever_of(const Channel& channel, const Instant& at);
/// Returns the derivatives of the rate relative to the Earth by all states on which it depends.
Eigen::MatrixXd rate_derivative(const Problem& problem, const Instant& at);
/// Returns the velocity of the point relative to the IMU, in body axes.
Derived swing_of(const Problem& problem, const Channel& channel, const Instant& at);
/// Returns the velocity of the point, east-north-up. Terms with a small time factor are differentiated only by that time.
Derived velocity_of(const Problem& problem, const Channel& channel, const Instant& at);
/// Returns its acceleration.
Vector3d acceleration_of(const Channel& channel, const Instant& at);

}  // namespace imulab::aided
