// The output of inertial sensors for navigation, and the effects inside a sampling interval: coning and sculling.
#pragma once

#include <Eigen/Core>

#include <span>

namespace imulab {

/// Integrals over an interval in body axes: of the angular rate [rad] and of the specific force [m/s].
struct Increment {
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// An increment and the length [s] of its interval.
struct TimedIncrement {
  Increment increment;
  double interval = 0;
};

namespace integration {

/// A body's motion over an interval: the rotation vector [rad] from its start to its end, and the velocity [m/s] that the specific force gives, in
/// the body axes of the start.
struct BodyStep {
  Eigen::Vector3d rotation, velocity;
};

/// From one sample and the one before it, of equal length (Savage 1998): exact for rates and forces that are linear in time, to the third order of
/// the angle.
BodyStep body_step(const Increment& sample, const Increment& previous);

/// From one to five samples of equal length (one: without coning and sculling; Ignagni 1996). Throws Error for another number.
BodyStep body_step(std::span<const Increment> samples);

}  // namespace integration

}  // namespace imulab
