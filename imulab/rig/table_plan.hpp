// The times of a turntable's steps that a calibration uses: the middle of each hold, and each turn with parts of the rests around it.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// An interval of the recording's clock, of one step. For a turn it reaches from the rest before it into the rest after it.
struct TablePart {
  std::size_t step = 0;       ///< index into the plan's steps
  double begin = 0, end = 0;  ///< s
  // As observed.
  Eigen::Vector3d shaking = Eigen::Vector3d::Zero();  ///< (m/s^2)^2: variance of a hold's accelerometers beyond their noise; none of counts
  std::optional<double> warming = {};                 ///< K from the recording's mean; absent: no thermometer
};

/// A procedure's parts, in the order of the steps.
struct TablePlan {
  std::vector<Step> steps;  ///< of one recording
  std::vector<TablePart> holds, turns;
  double begin = 0, end = 0;          ///< s: of the recording; without one, of the steps
  std::vector<std::string> warnings;  ///< turns that are left out, and why
};

/// `guard` [s] is left out at both ends of a hold (at most a quarter of it); a turn needs rest for that long before and after it, or is left out with
/// a warning. Throws Error for a spin, for steps that overlap or do not end after they begin, and for a turn that does not fit into its time
/// with its rate and acceleration.
TablePlan table_plan(const std::vector<Step>& steps, double guard);
/// With the guard that the table's declared timing requires: five sigmas.
TablePlan table_plan(const std::vector<Step>& steps, const RigDeclaration& rig);

/// The declaration of a recording's table. Throws Error where its rig is not a turntable.
const RigDeclaration& turntable_of(const Session& session, const std::string& recording);

/// The parts of a recording on a turntable. Throws Error where its rig is none, or it has no steps.
TablePlan table_plan(const Session& session, const std::string& recording);

// Observations of a table's steps in a recording: the means of the holds and the sums of the turns.

struct TableObservations {
  TablePlan parts;  ///< those that were observed, with the times of their samples
  /// Raw: of each hold the means of accelerometers and gyros (six rows), then of each turn the integral of the gyros (three).
  Eigen::VectorXd readings;
  Eigen::Vector3d accel_density = Eigen::Vector3d::Zero(), gyro_density = Eigen::Vector3d::Zero();  ///< raw / sqrt(Hz), from the samples of the holds
  double interval_s = 0.01;                                                                         ///< of the samples
  bool noise_measured = true;                                                                       ///< false: the holds are too short for that
  std::string accel_unit = "m/s^2", gyro_unit = "rad/s";                                            ///< of the raw readings; "count" for raw counts
  std::vector<std::string> notes, warnings;
};

/// Throws Error as table_plan does, Unsupported where no sample falls into the steps.
TableObservations observe(const Recording& recording, const Session& session);

}  // namespace imulab
