// A motion known in closed form, and the readings of an ideal IMU on it: the truth for simulation, error budgets and tests.
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
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // derivatives of those three numbers [m/s^2]
  Eigen::Matrix3d C_nb = Eigen::Matrix3d::Identity();      // body to east-north-up
  Eigen::Vector3d rate_nb_b = Eigen::Vector3d::Zero();     // of the body against east-north-up, in body axes [rad/s]
};

/// A motion as a function of time, more than 0.1 deg away from the poles.
struct Trajectory {
  double duration = 0;                        // s, from 0
  std::vector<double> breaks;                 // instants inside at which a derivative jumps: no quadrature runs across them
  std::function<Kinematics(double time)> at;  // for any time in [0, duration]
  double smooth = 0.1;                        // s, short against the fastest change: no quadrature panel is longer
};

/// The readings of an ideal IMU: rate against inertial space [rad/s] and specific force [m/s^2], in body axes.
struct BodyMotion {
  Eigen::Vector3d rate_ib_b, force_b;
};
/// Rotation of the Earth and of the east-north-up axes added; Coriolis acceleration added and WGS-84 gravity removed.
BodyMotion body_motion(const Kinematics& kinematics);

/// Increments from 0 to the end, each over `interval` [s], by Gauss-Legendre quadrature of the closed form with four points (no integrator runs).
/// The remainder at the end, shorter than an interval, has none. `progress` is called with the number of finished increments. Throws Error for an
/// interval that is not above 0.
std::vector<Increment> ideal_increments(const Trajectory& trajectory, double interval, const std::function<void(std::uint64_t)>& progress = {});

NavigationState navigation_state(const Kinematics& kinematics);

/// The motion at 0, at every `every`-th of the intervals [s], and at the end of the last whole one.
Solution truth(const Trajectory& trajectory, double interval, std::size_t every = 1);

/// A motion sample by sample: states at `time`, and what an ideal IMU reads from each to the next, one increment fewer; at equal intervals but for
/// jitter. True (nominal_motion), or as navigated.
struct NominalMotion {
  std::vector<double> time;  // s, ascending
  std::vector<NavigationState> states;
  std::vector<Increment> increments;
};
/// The trajectory from 0 to the end of its last whole interval [s].
NominalMotion nominal_motion(const Trajectory& trajectory, double interval);

}  // namespace imulab::motion
