// What an aid measures on a motion, with errors drawn.
//
//   const motion::Trajectory flown = motion::flight(start, segments);
//   const SimulatedAid receiver = simulate_aid({.kind = AidKind::gnss, .position_sigma = 1.5, .correlation = 60}, 0, flown, seed);
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <cstddef>
#include <cstdint>

namespace imulab {

/// The rate [Hz] of an aid that declares none: receivers 1, heading 1, wheels 10, barometers 10.
double aid_rate(const Aid& aid);

struct SimulatedAid {
  Aid aid;                                              ///< as declared, with its record on the recording's clock; nothing of a simulation
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  ///< as drawn, and so is the delay: the truth
  double delay = 0;
};

/// Measures the motion at its rate from 0 to the end. Lever arm and delay are drawn about the declared ones (0 where there is none) by their standard
/// deviations. Stamps are late by the delay. A receiver has position, velocity, or both, as their standard deviations are declared; without any both,
/// 1.5 m and 0.05 m/s. Wheels: 0.1 m/s, barometer: 1 m, heading: 1 deg. Errors of velocities are white; others, too, but with a correlation time they
/// are a stationary first-order Gauss-Markov process with white noise, which is a tenth of the variance. During jumps positions are displaced by the
/// jump, each in a horizontal direction of its own. Outages are the business of who reads the record: it has rows there, too. `number`: of the aid
/// among those of its mission, from 0. The same seed gives the same result. Throws Error for a kind without a record.
SimulatedAid simulate_aid(const Aid& declared, std::size_t number, const motion::Trajectory& motion, std::uint64_t seed);

/// The motion of an IMU on a rig that turns it in one place. Throws Error where the site lacks latitude, longitude or height, and for a rig that
/// moves it along.
motion::Trajectory trajectory_on_rig(const Session& procedure, const RecordingSource& source, const RigErrors& errors);

}  // namespace imulab
