// What an inertial sensor gives a navigator, and what happens inside its sampling interval: coning and sculling.
#pragma once

#include <Eigen/Core>

#include <span>

namespace imulab {

/// Integrals over an interval in body axes: of the angular rate [rad] and of the specific force [m/s].
struct Increment {
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// A body's motion over an interval: the rotation vector [rad] from its start to its end, and the velocity [m/s] that the specific force gives, in
/// the body axes of the start.
struct BodyStep {
  Eigen::Vector3d rotation, velocity;
};

/// From one sample and the one before it.
BodyStep body_step(const Increment& sample, const Increment& previous);

/// From one to five samples of equal length (one: without coning and sculling). `Error` for another number.
BodyStep body_step(std::span<const Increment> samples);

}  // namespace imulab
