// A motion in closed form, and the readings of an ideal IMU on it: the truth for simulation, error budgets and tests.
#pragma once

#include "imulab/navigate.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace imulab::motion {

/// A motion at one instant, with the derivatives that an IMU measures.
struct Kinematics {
  double latitude = 0, longitude = 0, height = 0;          // rad, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // east, north, up [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // derivatives of these three components [m/s^2]
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();      // body to east-north-up
  Eigen::Vector3d rate_nb_b = Eigen::Vector3d::Zero();     // rate of the body relative to east-north-up, in body axes [rad/s]
};

/// A motion as a function of time, more than 0.1 deg away from the poles.
struct Trajectory {
  double duration = 0;                        // s, from 0
  std::vector<double> breaks;                 // instants inside at which a derivative jumps: quadrature does not cross them
  std::function<Kinematics(double time)> at;  // for any time in [0, duration]
  double smooth = 0.1;                        // s, short compared with the fastest change: largest quadrature panel
};

/// The readings of an ideal IMU: rate relative to inertial space [rad/s] and specific force [m/s^2], in body axes.
struct BodyMotion {
  Eigen::Vector3d rate_ib_b, force_b;
};
/// Returns the readings: adds the rotation of the Earth and of the east-north-up axes, adds Coriolis acceleration and removes WGS-84 gravity.
BodyMotion body_motion(const Kinematics& kinematics);

/// Returns increments from 0 to the end, each over `interval` [s], by four-point Gauss-Legendre quadrature of the closed form (without an
/// integrator). The remainder at the end, shorter than an interval, is omitted. `progress` is called with the number of finished increments. Throws
/// Error unless the interval is above 0.
std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval, const std::function<void(std::uint64_t)>& progress = {});

NavigationState navigation_state(const Kinematics& kinematics);

/// Returns the motion at 0, at every `every`-th interval [s], and at the end of the last whole one.
Solution truth(const Trajectory& trajectory, double interval, std::size_t every = 1);

/// A motion sample by sample: states at `time`, and an ideal IMU's increments between them, one fewer; at equal intervals except for jitter. True
/// (nominal_motion), or as navigated.
struct NominalMotion {
  std::vector<double> time;  // s, ascending
  std::vector<NavigationState> states;
  std::vector<Increment> increments;
};
/// Returns the trajectory from 0 to the end of its last whole interval [s].
NominalMotion nominal_motion(const Trajectory& trajectory, double interval);

}  // namespace imulab::motion
