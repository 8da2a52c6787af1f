// A motion known in closed form, and what a perfect IMU reads on it: the truth for everything that integrates.
#pragma once

#include "imulab/navigation/attitude.hpp"
#include "imulab/navigation/strapdown.hpp"

#include <functional>
#include <vector>

namespace imulab {

/// A motion at one instant, with the derivatives that an IMU feels.
struct Kinematics {
  double latitude = 0, longitude = 0, height = 0;          // rad, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // east, north, up [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // derivatives of those three numbers [m/s^2]
  EulerAngles angles, angle_rates;                         // rad, rad/s
};

struct Trajectory {
  double duration = 0;                        // s, from 0
  std::vector<double> breaks;                 // instants inside where a derivative jumps: no quadrature runs across them
  std::function<Kinematics(double time)> at;  // for any time in [0, duration]
};

/// What a perfect IMU feels: rate against inertial space and specific force, in body axes.
struct BodyMotion {
  Eigen::Vector3d rate_ib_b, force_b;
};
BodyMotion body_motion(const Kinematics& kinematics);

/// Increments from 0 to the end, each over `interval` [s], by Gauss-Legendre quadrature of the closed form with four points (no integrator runs).
std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval);

NavigationState navigation_state(const Kinematics& kinematics);

}  // namespace imulab
