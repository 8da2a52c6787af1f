// What a turntable calibration uses of a recording: the means of the holds and the sums of the turns.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Means of the raw readings over [begin, end] of a hold.
struct HoldObservation {
  std::size_t step = 0;  ///< index into the steps
  double begin = 0, end = 0;
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
};

/// Integral of the raw gyro readings over [begin, end], from the rest before a turn into the rest after it.
struct TurnObservation {
  std::size_t step = 0;
  double begin = 0, end = 0;
  Vector3d sum = Vector3d::Zero();
};

struct TableObservations {
  std::vector<Step> steps;
  std::vector<HoldObservation> holds;
  std::vector<TurnObservation> turns;
  Vector3d accel_density = Vector3d::Zero(), gyro_density = Vector3d::Zero();  ///< raw / sqrt(Hz), from the samples of the holds
  bool noise_measured = true;                                                  ///< false: the holds are too short for that
  std::string accel_unit = "m/s^2", gyro_unit = "rad/s";                       ///< of the raw readings; "count" for raw counts
  std::vector<std::string> notes, warnings;

  /// Six rows a hold (accelerometers, gyros), then three rows a turn.
  Eigen::VectorXd values() const;
  void set_values(const Eigen::VectorXd& values);
};

/// "step 3 (hold at 120 s)"
std::string describe_step(const std::vector<Step>& steps, std::size_t index);

/// The table's declaration that belongs to a recording; throws Error where it is not a turntable.
const RigDeclaration& turntable_of(const Session& session, const std::string& recording);

/// The steps' intervals alone: what a procedure will observe, before any recording. `guard`: seconds left out at both ends of a hold.
TableObservations planned_observations(const std::vector<Step>& steps, double guard);
/// With the guard that the table's timing asks for: five sigmas.
TableObservations planned_observations(const std::vector<Step>& steps, const RigDeclaration& rig);
/// Of a recording of a turntable's session. Throws Error where it has no steps.
TableObservations planned_observations(const Session& session, const std::string& recording);

/// Throws Error where the session has no steps of a turntable, Unsupported where no sample falls into them.
TableObservations observe(const Recording& recording, const Session& session);

}  // namespace imulab
