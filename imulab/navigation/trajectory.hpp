// A motion known in closed form, and what a perfect IMU reads on it: the truth for everything that integrates.
#pragma once

#include "imulab/navigation/solution.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace imulab {

/// A motion at one instant, with the derivatives that an IMU feels.
struct Kinematics {
  double latitude = 0, longitude = 0, height = 0;          // rad, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // east, north, up [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // derivatives of those three numbers [m/s^2]
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();      // body to east-north-up
  Eigen::Vector3d rate_nb_b = Eigen::Vector3d::Zero();     // of the body against east-north-up, in body axes [rad/s]
};

struct Trajectory {
  double duration = 0;                        // s, from 0
  std::vector<double> breaks;                 // instants inside where a derivative jumps: no quadrature runs across them
  std::function<Kinematics(double time)> at;  // for any time in [0, duration]
  double smooth = 0.1;                        // s, short against all that moves: no quadrature runs over more
};

/// What a perfect IMU feels: rate against inertial space and specific force, in body axes.
struct BodyMotion {
  Eigen::Vector3d rate_ib_b, force_b;
};
BodyMotion body_motion(const Kinematics& kinematics);

/// Increments from 0 to the end, each over `interval` [s], by Gauss-Legendre quadrature of the closed form with four points (no integrator runs).
/// What is left at the end, shorter than an interval, has none. `progress` is called with the number of finished increments.
std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval, const std::function<void(std::uint64_t)>& progress = {});

NavigationState navigation_state(const Kinematics& kinematics);

/// The motion at 0, at every `every`-th of the intervals, and at the end of the last whole one.
Solution truth(const Trajectory& trajectory, double interval, std::size_t every = 1);

}  // namespace imulab
